#include "devices/placed_device.h"

#include <algorithm>
#include <array>
#include <utility>

namespace hapton {
namespace {

// Sets the workspace to the box along the axes of W that contains the turned box.
void place_workspace(DeviceLimits& limits, const Pose& X_WB) {
  const Vec3 middle_B = 0.5 * (limits.workspace_min_m + limits.workspace_max_m);
  const Vec3 half_B = 0.5 * (limits.workspace_max_m - limits.workspace_min_m);
  const Vec3 middle_W = X_WB * middle_B;
  const Vec3 half_W = X_WB.linear().cwiseAbs() * half_B;
  limits.workspace_min_m = middle_W - half_W;
  limits.workspace_max_m = middle_W + half_W;
}

}  // namespace

PlacedDevice::PlacedDevice(std::unique_ptr<Device> device, const Pose& X_WB)
    : device_(std::move(device)), X_WB_(X_WB), X_BW_(X_WB.inverse()), q_WB_(X_WB.linear()), limits_(device_->limits()) {
  place_workspace(limits_, X_WB_);
}

DeviceSample PlacedDevice::read(std::int64_t now_ns) noexcept {
  DeviceSample sample = device_->read(now_ns);
  sample.p_WD = X_WB_ * sample.p_WD;
  sample.q_WT = q_WB_ * sample.q_WT;
  return sample;
}

void PlacedDevice::write(const Wrench& wrench, std::int64_t now_ns) noexcept {
  device_->write({.force_n = X_BW_.linear() * wrench.force_n, .torque_nm = X_BW_.linear() * wrench.torque_nm}, now_ns);
}

bool PlacedDevice::set_hand_target(const std::optional<Vec3>& p_WH) noexcept {
  return device_->set_hand_target(p_WH ? std::optional<Vec3>(X_BW_ * *p_WH) : std::nullopt);
}

bool PlacedDevice::aim_hand(std::span<const Vec3> p_WA) noexcept {
  std::array<Vec3, kMaxAims> p_BA;
  const std::size_t count = std::min(p_WA.size(), p_BA.size());
  for (std::size_t i = 0; i < count; ++i) p_BA[i] = X_BW_ * p_WA[i];
  return device_->aim_hand(std::span(p_BA).first(count));
}

}  // namespace hapton
