#include "io_node/session_setup.h"

#include <chrono>
#include <cmath>

#include "runtime/build_id.h"
#include "runtime/state_folder.h"

namespace hapton {
namespace {

std::string describe_limit(double limit) { return std::isfinite(limit) ? fmt::format("{}", limit) : "the device's own"; }

}  // namespace

SessionHeader make_session_header(const IoOptions& options, std::uint64_t session, const Clock& clock) {
  SessionHeader header;
  header.build = build_id();
  header.start_ns = clock.now_ns();
  header.start_unix_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  header.session = session;
  header.settings = {{"bind", options.bind},
                     {"device", options.device.name},
                     {"rate", fmt::format("{}", options.rate_hz)},
                     {"vision-rate", fmt::format("{}", options.vision_rate_hz)},
                     {"seed", fmt::format("{}", options.device.seed)},
                     {"max-force", describe_limit(options.device.max_force_n)},
                     {"max-slew", fmt::format("{}", options.device.max_slew_n_per_s)},
                     {"max-torque", describe_limit(options.device.max_torque_nm)},
                     {"continuous-force", fmt::format("{}", options.device.continuous_force_n)},
                     {"max-speed", fmt::format("{}", options.device.max_speed_m_per_s)},
                     {"dead-mans-switch", fmt::format("{}", options.device.dead_mans_switch)},
                     {"clutch-button", fmt::format("{}", options.device.clutch_button)},
                     {"passive-mass", fmt::format("{}", options.device.passive_mass_kg)},
                     {"passive-damping", fmt::format("{}", options.device.passive_damping_ns_per_m)},
                     {"passive-friction", fmt::format("{}", options.device.passive_friction_n)},
                     {"passive-step", fmt::format("{}", options.device.passive_position_step_m)},
                     {"overrun", options.overrun}};
  const auto add_text = [&](const char* name, const std::string& value) {
    if (!value.empty()) header.settings.emplace_back(name, value);
  };
  add_text("name", options.name);
  add_text("device-id", options.device.id);
  add_text("device-file", options.device.file);
  add_text("trajectory", options.device.trajectory);
  return header;
}

std::filesystem::path find_flight_folder(const IoOptions& options) {
  if (options.flight == "off") return {};
  const auto of_device = [&](const std::filesystem::path& folder) { return options.name.empty() ? folder : folder / options.name; };
  if (!options.flight.empty()) return of_device(options.flight);
  if (!options.out.empty()) return std::filesystem::path(options.out) / "flight";
  const std::filesystem::path state = find_state_folder();
  return state.empty() ? state : of_device(state / "flight");
}

std::string describe_missing_means(const HeartbeatPage& page, std::string_view device) {
  if (page.means.load(std::memory_order_acquire) != CutMeans::none) return {};
  return fmt::format(
      "the watchdog process cannot release the force of this device ({}), as its driver does not say how (Device::use_heartbeat_page): "
      "only io_node itself and the device can",
      device);
}

std::string describe_lost_samples(const IoOptions& options, std::uint64_t lost) {
  if (options.record.empty() || lost == 0) return {};
  return fmt::format("{}{}: {} samples are missing in the recording (column `lost` of its table): io_node got no CPU for too long",
                     name_prefix(options), options.record, lost);
}

}  // namespace hapton
