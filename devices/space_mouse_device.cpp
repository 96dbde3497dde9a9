#include "devices/space_mouse_device.h"

#include <algorithm>
#include <utility>

#include "hid/hidapi_transport.h"

namespace hapton {
namespace {

// The room that a hand with a stylus has on a desk.
const Vec3 kHalfWorkspaceM(0.15, 0.12, 0.15);
// The longest time for which a read moves the point, so that the point does not jump after a late read: 3 mm at full speed.
constexpr double kLongestStepS = 0.02;

// No motors: the force limit is what an ordinary device has, so that contact is computed in full.
DeviceLimits make_limits() {
  return {.max_force_n = 8.0,
          .max_slew_n_per_s = 2000.0,
          .max_stiffness_n_per_m = 1000.0,
          .workspace_min_m = -kHalfWorkspaceM,
          .workspace_max_m = kHalfWorkspaceM};
}

Vec3 to_speed(const Vec3& share, double full_speed) noexcept { return full_speed * share.norm() * share; }

}  // namespace

SpaceMouseDevice::SpaceMouseDevice(std::unique_ptr<SpaceMouseReader> reader) : reader_(std::move(reader)), limits_(make_limits()) {
  sample_.p_WD = Vec3(0.0, 0.0, 0.9 * limits_.workspace_max_m.z());
}

DeviceSample SpaceMouseDevice::read(std::int64_t now_ns) noexcept {
  const SpaceMouseState mouse = reader_->state(now_ns);
  const double step_s = read_ns_ < 0 ? 0.0 : std::clamp(1e-9 * static_cast<double>(now_ns - read_ns_), 0.0, kLongestStepS);
  read_ns_ = now_ns;
  if (reader_->is_there()) {
    const Vec3 speed = to_speed(mouse.push, kFullSpeedMPerS) + force_n_ / kDampingNsPerM;
    sample_.p_WD = (sample_.p_WD + step_s * speed).cwiseMax(limits_.workspace_min_m).cwiseMin(limits_.workspace_max_m);
    const Vec3 turn = step_s * to_speed(mouse.turn, kFullTurnRadPerS);
    if (const double angle = turn.norm(); angle > 0.0) {
      sample_.q_WT = (Quat(Eigen::AngleAxisd(angle, turn / angle)) * sample_.q_WT).normalized();
    }
  }
  sample_.buttons = mouse.buttons;
  sample_.time_ns = now_ns;
  return sample_;
}

DeviceCondition SpaceMouseDevice::condition() const noexcept {
  return {.model = reader_->description().product, .serial = reader_->description().serial, .firmware = {}};
}

Result<std::unique_ptr<Device>> make_space_mouse(const DeviceSettings& settings) {
  auto reader = std::make_unique<SpaceMouseReader>(make_hid_opener(HidKind::space_mouse, settings.id));
  if (auto opened = reader->open(); !opened) return tl::unexpected(opened.error());
  return std::make_unique<SpaceMouseDevice>(std::move(reader));
}

}  // namespace hapton
