#include "devices/hapton_hid_device.h"

#include <algorithm>
#include <array>

#include "devices/hid_device.h"
#include "hid/hidapi_transport.h"

namespace hapton {
namespace {

DeviceLimits to_device_limits(const hapton_hid::Limits& limits) {
  return {.max_force_n = limits.max_force_n,
          .max_slew_n_per_s = limits.max_slew_n_per_s,
          .max_stiffness_n_per_m = limits.max_stiffness_n_per_m,
          .workspace_min_m = limits.workspace_min_m,
          .workspace_max_m = limits.workspace_max_m,
          .max_torque_nm = limits.max_torque_nm,
          .max_torque_slew_nm_per_s = limits.max_torque_slew_nm_per_s,
          .continuous_force_n = limits.continuous_force_n,
          .peak_s = limits.peak_s,
          .max_speed_m_per_s = limits.max_speed_m_per_s};
}

// The most important state counts: a fault, then a device that cannot exert force now, then one that does not know its position.
DeviceStatus status_of(const hapton_hid::State& state) noexcept {
  if (state.has_fault) return DeviceStatus::fault;
  if (state.has_tripped) return DeviceStatus::away;
  return state.is_calibrated ? DeviceStatus::ready : DeviceStatus::calibrating;
}

}  // namespace

Result<void> HaptonHidBackend::on_open(HidTransport& transport) {
  const std::string& path = transport.description().path;
  std::array<std::uint8_t, 256> report = {hapton_hid::kLimitsId};
  const auto limits_size = transport.get_feature(report);
  if (!limits_size) return tl::unexpected(limits_size.error());
  const auto limits = hapton_hid::decode_limits(std::span(report).first(std::min(*limits_size, report.size())));
  if (!limits) return fail("{}: {}", path, limits.error().what);
  report = {hapton_hid::kNamesId};
  const auto names_size = transport.get_feature(report);
  if (!names_size) return tl::unexpected(names_size.error());
  const auto names = hapton_hid::decode_names(std::span(report).first(std::min(*names_size, report.size())));
  if (!names) return fail("{}: {}", path, names.error().what);
  if (limits_ && (*limits != *limits_ || names->serial != names_.serial)) {
    return fail("{}: {} {} is not the same device as before, or its limits differ; restart io_node to use it", path, names->model,
                names->serial);
  }
  newest_state_.reset();
  if (limits_) return {};
  limits_ = *limits;
  device_limits_ = to_device_limits(*limits);
  names_ = *names;
  return {};
}

bool HaptonHidBackend::decode(std::span<const std::uint8_t> report, std::int64_t, DeviceExchange::Reading& reading) noexcept {
  const auto state = hapton_hid::decode_state(report);
  if (!state || !limits_ || state->sequence == newest_state_) return false;
  newest_state_ = state->sequence;
  reading.status = status_of(*state);
  reading.is_calibrated = state->is_calibrated;
  reading.motor_temperature = state->temperature;
  reading.sample.p_WD = state->position_m;
  reading.sample.q_WT = limits_->has_orientation ? state->orientation : Quat::Identity();
  reading.sample.buttons = state->buttons;
  reading.sample.is_held = state->is_held || !limits_->knows_held;
  return true;
}

std::size_t HaptonHidBackend::encode(const Wrench& wrench, bool is_live, std::int64_t, std::span<std::uint8_t> into) noexcept {
  hapton_hid::Force force{.is_on = is_live, .sequence = ++sequence_, .newest_state = newest_state_.value_or(0)};
  if (is_live) {
    force.force_n = wrench.force_n;
    if (limits_ && limits_->has_torque) force.torque_nm = wrench.torque_nm;
  }
  const auto report = hapton_hid::encode_force(force);
  if (into.size() < report.size()) return 0;
  std::copy(report.begin(), report.end(), into.begin());
  return report.size();
}

Result<std::unique_ptr<Device>> make_hapton_hid(const DeviceSettings& settings) {
  return HidDevice::open(std::make_unique<HaptonHidBackend>(), make_hid_opener(HidKind::hapton_hid, settings.id), settings.realtime);
}

}  // namespace hapton
