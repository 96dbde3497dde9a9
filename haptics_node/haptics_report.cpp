#include "haptics_node/haptics_report.h"

#include <algorithm>
#include <sstream>

#include "runtime/log.h"

namespace hapton {
namespace {

std::string describe_joins(std::uint64_t joins) { return joins == 1 ? std::string("once") : fmt::format("{} times", joins); }

}  // namespace

std::string describe_times(const std::string& what, const LatencyHistogram& times) {
  if (times.count() == 0) return {};
  const auto us = [&](double fraction) { return 1e-3 * times.quantile_ns(fraction); };
  return fmt::format("{}: p50 {:.2f} us, p90 {:.2f}, p99 {:.2f}, p99.9 {:.2f}, worst {:.2f}, n {}\n", what, us(0.5), us(0.9), us(0.99),
                     us(0.999), 1e-3 * static_cast<double>(times.max_ns()), times.count());
}

std::string describe_late_tool(const HeldTool::Lateness& lateness) {
  if (lateness.faded == 0) return {};
  return fmt::format(
      "the pose of the tool was more than {:.0f} ms late in {:.2g} % of samples, {:.0f} ms at most: the force faded meanwhile. "
      "A coarser mesh, fewer other programs or more cores (--tool-threads) help",
      1e3 * HeldTool::kFreshS, 100.0 * static_cast<double>(lateness.faded) / static_cast<double>(lateness.samples),
      1e3 * lateness.longest_s);
}

std::string describe_spins(const StateWait& wait) {
  if (wait.spins() == 0) return {};
  const auto spins = static_cast<double>(wait.spins());
  return fmt::format("waits that spun: {}, {:.1f} us each, {:.1f} % ended with a sample\n", wait.spins(),
                     1e-3 * static_cast<double>(wait.spun_ns()) / spins, 100.0 * static_cast<double>(wait.arrivals()) / spins);
}

std::string make_haptics_report(const HapticsStep& step, const HubClient& hub, const LatencyHistogram& compute_times,
                                const LatencyHistogram& step_times) {
  const HapticsCounts& counts = step.counts();
  std::string text = fmt::format(
      "haptics_node: {} samples with a reply, {} in contact, maximum {:.3f} N; {} skipped, {} lost, {} reordered; joined the hub {}\n",
      counts.replied, counts.contact_steps, counts.max_force_n, counts.skipped, hub.sequence_counts().lost, hub.sequence_counts().reordered,
      describe_joins(hub.counts().joins));
  text += describe_times("step", step_times);
  text += describe_times("arrival to reply", compute_times);
  if (counts.views_applied + counts.views_rejected > 0) {
    text += fmt::format("view transforms: {} applied, {} rejected (not rigid)\n", counts.views_applied, counts.views_rejected);
  }
  if (counts.method_changes > 0) {
    text += fmt::format("methods changed while running: {}\n", counts.method_changes);
  }
  if (step.holds_tool()) {
    const double mean = static_cast<double>(counts.haptons) / static_cast<double>(std::max<std::uint64_t>(1, counts.contact_steps));
    return text + fmt::format("tool: maximum {:.4f} Nm; pairs of triangles in contact (haptons): {:.1f} on average, {} at most\n",
                              counts.max_torque_nm, mean, counts.most_haptons);
  }
  return text + step.touch().method().describe();
}

void log_method(const ForceMethod& method) {
  std::istringstream text(method.describe());
  std::string first_of_objects;
  std::size_t of_objects = 0;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("note: ")) {
      log_warning("{}", line.substr(6));
    } else if (!line.starts_with("object ")) {
      log_info("{}", line);
    } else if (++of_objects == 1) {
      first_of_objects = line;
    }
  }
  if (of_objects == 1) log_info("{}", first_of_objects);
  if (of_objects > 1) log_info("{} (and {} more lines on objects)", first_of_objects, of_objects - 1);
}

}  // namespace hapton
