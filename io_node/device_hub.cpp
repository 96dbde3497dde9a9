#include "io_node/device_hub.h"

#include <fmt/core.h>
#include <cmath>

#include <utility>

#include "devices/device_maker.h"
#include "io_node/io_session.h"
#include "io_node/latch_file.h"
#include "io_node/patch_link.h"
#include "io_node/session_recorder.h"
#include "io_node/session_setup.h"
#include "io_node/vrpn/vrpn_server.h"
#include "link/budgeted_endpoint.h"
#include "link/link_key.h"
#include "link/metered_endpoint.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/log.h"
#include "runtime/standard_streams.h"
#include "watchdog/watchdog_supervisor.h"

namespace hapton {
namespace {

// Measurement of the bare echo, with its own socket; empty without --echo-probe.
struct Echo {
  std::unique_ptr<Endpoint> endpoint;
  std::unique_ptr<EchoProbe> probe;
};

Result<Echo> open_echo(const IoOptions& options, const Clock& clock) {
  Echo echo;
  if (options.echo_probe.empty()) return echo;
  const auto responder = parse_address(options.echo_probe);
  if (!responder) return tl::unexpected(responder.error());
  auto endpoint = open_udp_endpoint(any_address_like(*responder));
  if (!endpoint) return tl::unexpected(endpoint.error());
  echo.endpoint = std::move(*endpoint);
  echo.probe = std::make_unique<EchoProbe>(*echo.endpoint, clock, *responder, options.echo_bytes);
  return echo;
}

OverrunPolicy overrun_policy(const IoOptions& options) {
  if (options.overrun == "catch-up") return OverrunPolicy::catch_up;
  return options.overrun == "stop" ? OverrunPolicy::stop : OverrunPolicy::skip;
}

// Null if metrics are off.
Result<std::unique_ptr<MetricsEndpoint>> open_metrics(const IoOptions& options) {
  if (options.metrics.empty()) return std::unique_ptr<MetricsEndpoint>();
  auto metrics = MetricsEndpoint::open(options.metrics);
  if (metrics) log_info("{}metrics at http://{}/metrics", name_prefix(options), to_string((*metrics)->local_address()));
  return metrics;
}

// A device's own thread gets the same real-time priority. Settings of the whole process are left to the network side's thread.
DeviceSettings device_settings(const IoOptions& options) {
  DeviceSettings settings = options.device;
  if (options.realtime.mode == RealtimeMode::off) return settings;
  settings.realtime = RealtimeSettings{
      .mode = RealtimeMode::attempt, .priority = options.realtime.priority, .cpu = -1, .lock_memory = false, .low_dma_latency = false};
  return settings;
}

// VRPN server and its source of samples; empty without --vrpn.
struct VrpnOutput {
  std::unique_ptr<vrpn::Feed> feed;
  std::unique_ptr<vrpn::Server> server;
};

Result<VrpnOutput> open_vrpn(const IoOptions& options, std::unique_ptr<Device>& device) {
  VrpnOutput output;
  if (options.vrpn.empty()) return output;
  output.feed = std::make_unique<vrpn::Feed>();
  auto server = vrpn::Server::open(*output.feed, {.address = options.vrpn, .name = options.vrpn_name, .limits = device->limits()});
  if (!server) return tl::unexpected(server.error());
  output.server = std::move(*server);
  device = std::make_unique<vrpn::WatchedDevice>(std::move(device), *output.feed);
  return output;
}

SessionRecorder::Options recording_of(const IoOptions& options) {
  SessionRecorder::Options recording{options.record, find_flight_folder(options)};
  recording.makes_flight_folder = !options.flight.empty();
  if (!options.record.empty()) recording.ring_bytes = SessionRecorder::kRecordRingBytes;
  return recording;
}

void print_recording(const IoOptions& options, const SessionRecorder::Counts& counts) {
  if (!options.record.empty()) {
    // A recording that was stopped early also lacks the entries that came afterwards.
    const std::string all = counts.file_entries < counts.entries ? fmt::format(" of {}", counts.entries) : "";
    print_text("recorded {}{} entries, {:.1f} MB, {} dropped: {}\n", counts.file_entries, all,
               1e-6 * static_cast<double>(counts.file_bytes), counts.dropped, options.record);
  }
  if (const std::string missing = describe_lost_samples(options, counts.lost_samples); !missing.empty()) log_warning("{}", missing);
  if (counts.flights + counts.flights_left_out > 0) {
    print_text("faults: {} flight records written, {} skipped\n", counts.flights, counts.flights_left_out);
  }
}

DeviceLimits tighter_limits(const DeviceSettings& settings) {
  return {.max_force_n = settings.max_force_n,
          .max_slew_n_per_s = settings.max_slew_n_per_s,
          .max_torque_nm = settings.max_torque_nm,
          .continuous_force_n = settings.continuous_force_n,
          .max_speed_m_per_s = settings.max_speed_m_per_s};
}

std::optional<PassivityController::Mechanics> passive_mechanics(const DeviceSettings& settings) {
  if (settings.passive_mass_kg == 0.0) return std::nullopt;
  return PassivityController::Mechanics{settings.passive_mass_kg, settings.passive_damping_ns_per_m, settings.passive_friction_n,
                                        settings.passive_position_step_m};
}

void warn_of_loose_limits(const IoOptions& options, const DeviceLimits& device_limits) {
  const bool is_own_force = std::isinf(options.device.max_force_n) || options.device.max_force_n <= device_limits.max_force_n;
  if (is_own_force && options.device.max_slew_n_per_s <= device_limits.max_slew_n_per_s) return;
  log_warning("{}limits can only be tightened: the device's own apply, {:.2f} N and {:.0f} N/s", name_prefix(options),
              device_limits.max_force_n, device_limits.max_slew_n_per_s);
}

}  // namespace

// Members in the order of their dependencies.
struct DeviceHub::Parts {
  Parts(const IoOptions& options_in, const Clock& steady, VrpnOutput vrpn_in, std::unique_ptr<Device> device_in,
        std::unique_ptr<Endpoint> endpoint_in, Echo echo_in, std::unique_ptr<MetricsEndpoint> metrics_in, const LinkKey& key)
      : options(options_in),
        vrpn_output(std::move(vrpn_in)),
        device(std::move(device_in)),
        endpoint(std::move(endpoint_in)),
        echo(std::move(echo_in)),
        metrics(std::move(metrics_in)),
        metered(*endpoint, steady),
        budget(metered, clock),
        sealed(budget, steady, key, AgreementWorker::Where::own_thread),
        recorder(recording_of(options), make_session_header(options, session_id, steady), steady),
        peers(sealed, steady, session_id, options.rate_hz),
        network(std::make_unique<NetworkLoop>(*device, peers, steady, network_options(), echo.probe.get(), tap())),
        hops(metered),
        latch_file(find_latch_file(options.device.name + options.device.id, options.bind)),
        session(*network, steady, options) {
    network->set_hop_meter(&hops);
    network->set_budget(&budget);
    network->set_report_server(&report_server);
    network->set_vrpn_feed(vrpn_output.feed.get());
    if (options.touch != TouchChoice::remote) use_patches();
    session.set_report_server(&report_server);
    session.set_metrics(metrics.get());
  }

  NetworkLoop::Options network_options() const {
    return {.rate_hz = options.rate_hz,
            .vision_rate_hz = options.vision_rate_hz,
            .tighter_limits = tighter_limits(options.device),
            .forbids_force = options.device.max_force_n <= kMinUsableLimit,
            .forbids_torque = options.device.max_torque_nm <= kMinUsableLimit,
            .passive_mechanics = passive_mechanics(options.device),
            .dead_mans_switch = options.device.dead_mans_switch,
            .clutch_button = options.device.clutch_button,
            .overrun = overrun_policy(options),
            .spin_share = options.spin_share,
            .reply_spin_ns = std::llround(1e3 * options.reply_spin_us)};
  }
  void use_patches() {
    local_patch = std::make_unique<LocalPatch>();
    patch_thread = std::make_unique<PatchThread>(*local_patch);
    patch_link = std::make_unique<PatchLink>(peers, *local_patch, *patch_thread, options.touch);
    network->device_loop().set_local_touch(local_patch.get());
    network->set_patch_link(patch_link.get());
  }
  ServoTap* tap() { return options.record.empty() && find_flight_folder(options).empty() ? nullptr : &recorder; }

  const IoOptions options;
  VrpnOutput vrpn_output;
  HeartbeatMemory heartbeat;  // outlives `device`, whose driver uses its page
  std::unique_ptr<Device> device;
  std::unique_ptr<Endpoint> endpoint;
  Echo echo;
  std::unique_ptr<MetricsEndpoint> metrics;
  MeteredEndpoint metered;
  SteadyClock clock;
  BudgetedEndpoint budget;
  SealedHub sealed;
  const std::uint64_t session_id = make_random_id();
  SessionRecorder recorder;
  HubPeers peers;
  std::unique_ptr<LocalPatch> local_patch;  // null if all forces come from the haptics node
  std::unique_ptr<PatchThread> patch_thread;
  std::unique_ptr<PatchLink> patch_link;
  std::unique_ptr<NetworkLoop> network;
  HopMeter hops;
  ReportServer report_server;
  WatchdogSupervisor watchdog;
  LatchFile latch_file;
  IoSession session;
};

DeviceHub::DeviceHub(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DeviceHub::~DeviceHub() = default;

Result<std::unique_ptr<DeviceHub>> DeviceHub::open(const IoOptions& options, const Clock& clock) {
  auto device = make_device(device_settings(options));
  if (!device) return tl::unexpected(device.error());
  const auto address = parse_address(options.bind);
  if (!address) return tl::unexpected(address.error());
  const auto key = find_link_key(options.key_file, *address);
  if (!key) return tl::unexpected(key.error());
  auto endpoint = open_udp_endpoint(options.bind, true);
  if (!endpoint) return tl::unexpected(endpoint.error());
  auto echo = open_echo(options, clock);
  if (!echo) return tl::unexpected(echo.error());
  auto metrics = open_metrics(options);
  if (!metrics) return tl::unexpected(metrics.error());
  auto output = open_vrpn(options, *device);
  if (!output) return tl::unexpected(output.error());
  warn_of_loose_limits(options, (*device)->limits());
  return std::unique_ptr<DeviceHub>(new DeviceHub(std::make_unique<Parts>(
      options, clock, std::move(*output), std::move(*device), std::move(*endpoint), std::move(*echo), std::move(*metrics), *key)));
}

void DeviceHub::set_service(ServiceLiveness* service, std::size_t number) noexcept { parts_->session.set_service(service, number); }

Address DeviceHub::address() const { return parts_->endpoint->local_address(); }
const IoOptions& DeviceHub::options() const { return parts_->options; }

std::string DeviceHub::describe() const {
  const IoOptions& options = parts_->options;
  return fmt::format("{}hub on {}, device {}, {:g} Hz, at most {:.2f} N, seed {}", name_prefix(options), to_string(address()),
                     parts_->device->name(), options.rate_hz, parts_->network->limits().max_force_n, options.device.seed);
}

// Starts the process that releases the force when this one cannot. Without it only this process itself releases the force.
Result<void> DeviceHub::start_watchdog() {
  const IoOptions& options = parts_->options;
  if (options.watchdog == RealtimeMode::off) return {};
  Result<void> started = parts_->heartbeat.make();
  if (started) {
    parts_->device->use_heartbeat_page(parts_->heartbeat.page());
    if (const std::string missing = describe_missing_means(parts_->heartbeat.page(), parts_->device->name()); !missing.empty()) {
      if (options.watchdog == RealtimeMode::require) return fail("{}", missing);
      log_warning("{}{}", name_prefix(options), missing);
    }
    parts_->network->device_loop().set_heartbeat_page(&parts_->heartbeat.page());
    const bool is_realtime = options.realtime.mode != RealtimeMode::off && options.realtime.priority > 0;
    // Above the network side, and the device side, which is one above it (DeviceThread).
    const int priority = is_realtime ? std::min(options.realtime.priority + 2, kMaxRealtimePriority) : 0;
    started = parts_->watchdog.start(parts_->heartbeat, WatchdogSupervisor::find_program(), priority);
  }
  if (started) parts_->session.set_watchdog(&parts_->watchdog);
  if (started || options.watchdog == RealtimeMode::require) return started;
  log_warning("{}{}", name_prefix(options), started.error().what);
  return {};
}

// Latches the fault that was latched when this program last ended.
void DeviceHub::restore_latched_fault() {
  const SafetyFault fault = parts_->latch_file.read();
  parts_->session.set_latch_file(&parts_->latch_file);
  if (fault == SafetyFault::none) return;
  parts_->network->device_loop().restore_latched_fault(fault);
  log_warning(
      "{}no force: a fault latched before this start has not been reset: {}; fix the cause, then: hapton set --reset-faults "
      "(docs/safety.md)",
      name_prefix(parts_->options), hapton::describe(fault));
}

Result<void> DeviceHub::run(const StopSignal& stop) {
  restore_latched_fault();
  if (auto watched = start_watchdog(); !watched) return watched;
  if (const auto started = parts_->recorder.start(); !started) return started;
  const auto ended = parts_->session.run(stop);
  keep_device_failure();
  const auto recorded = parts_->recorder.stop();
  print_recording(parts_->options, parts_->recorder.counts());
  if (!ended && !recorded) log_error("{}{}", name_prefix(parts_->options), recorded.error().what);
  return ended ? recorded : ended;
}

// A fault that was latched before stays in the file.
void DeviceHub::keep_device_failure() {
  if (!has_device_failed() || parts_->latch_file.read() != SafetyFault::none) return;
  if (const auto kept = parts_->latch_file.keep(SafetyFault::device); !kept) {
    log_warning("{}the latched fault could not be saved, so a restart would reset it: {}", name_prefix(parts_->options), kept.error().what);
  }
}

void DeviceHub::forget_device_failure() {
  if (has_device_failed() && parts_->latch_file.read() == SafetyFault::device) parts_->latch_file.forget();
}

bool DeviceHub::has_device_failed() const { return parts_->network->device_status() == DeviceStatus::fault; }

}  // namespace hapton
