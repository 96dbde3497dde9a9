#include "core/tool/held_tool.h"

#include <algorithm>

namespace hapton {
namespace {

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

constexpr double kLeastReach = 64.0 * ToolProxy::kContactOffset;
// Of the tool's radius. Farther contacts would come earlier, and the next ones later: to find them takes longer.
constexpr double kMostReach = 1.0 / 64.0;

}  // namespace

ToolOutput HeldTool::step(const ToolInput& input, std::int64_t time_ns) noexcept {
  ToolOutput output;
  output.X_WP = input.X_WD;
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return output;
  const Placement device = tool_->to_local(input);
  samples_.publish({device, time_ns, serial_});
  found_.take();
  const Found& found = found_.value();
  output.proxy = found.step;
  const bool is_known = found.serial == serial_;
  output.proxy.is_blocked = is_known && found.contacts.is_blocked;
  age_s_ = is_known ? std::max(0.0, seconds(time_ns - found.time_ns)) : 0.0;
  if (!is_known || output.proxy.is_blocked) return output;
  const ToolProxyStep step = output.proxy;
  output = tool_->felt_at(input, device, found.contacts.constrain(device));
  output.proxy = step;
  const double share = std::clamp((kStaleS - age_s_) / (kStaleS - kFreshS), 0.0, 1.0);
  output.force_n *= share;
  output.torque_nm *= share;
  return output;
}

bool HeldTool::follow() noexcept {
  if (!samples_.take()) return false;
  const Sample& sample = samples_.value();
  Found& found = found_.draft();
  ToolProxy& proxy = tool_->proxy();
  const bool is_first = sample.serial != last_.serial;
  if (is_first) proxy.reset(sample.device);
  found.step = proxy.step(sample.device);
  // As far as the device gets before the next contacts come, if it goes on like that.
  const RigidMotion moved{last_.device, sample.device.position - last_.device.position,
                          turn_between(last_.device.orientation, sample.device.orientation)};
  const double reach = is_first ? kLeastReach : std::max(kLeastReach, 2.0 * moved.length(proxy.radius()));
  proxy.find_local_contacts(std::min(reach, kMostReach * proxy.radius()), found.contacts);
  found.time_ns = sample.time_ns;
  found.serial = sample.serial;
  last_ = sample;
  found_.publish_draft();
  return true;
}

}  // namespace hapton
