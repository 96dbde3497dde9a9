#include "io_node/loop_reporter.h"

#include <algorithm>

namespace hapton {

LoopReporter::LoopReporter(HubPeers& peers, const ServoStats& stats, std::string_view device, double max_torque_nm) noexcept
    : peers_(peers), stats_(stats) {
  facts_.max_torque_nm = static_cast<float>(max_torque_nm);
  std::copy_n(device.begin(), std::min(device.size(), facts_.device.size() - 1), facts_.device.begin());
}

void LoopReporter::send_if_due(double rate_hz, std::int64_t now_ns) noexcept {
  if (now_ns < next_ns_ || stats_.round_trip.count() < kMinTrips || !peers_.has_haptics()) return;
  next_ns_ = now_ns + kEveryNs;
  facts_.servo_rate_hz = rate_hz;
  facts_.round_trip_s = static_cast<float>(1e-9 * static_cast<double>(stats_.round_trip.quantile_ns(0.99)));
  peers_.send_to_role(NodeRole::haptics, facts_);
}

}  // namespace hapton
