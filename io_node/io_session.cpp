#include "io_node/io_session.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>
#include <utility>

#include <fmt/core.h>

#include "devices/plugin_device.h"
#include "io_node/io_report.h"
#include "link/udp_endpoint.h"
#include "link/wire_text.h"
#include "runtime/log.h"
#include "runtime/prometheus_text.h"
#include "runtime/report.h"
#include "runtime/standard_streams.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr std::int64_t kWatchEveryNs = kNanosecondsPerSecond / 4;         // between two checks of scheduling, and of the loop's heartbeat
constexpr std::int64_t kMinMetricsPeriodNs = kNanosecondsPerSecond / 10;  // between two copies of the statistics for requests
// Between two checks for events, reports and the end; too short for a person to notice.
constexpr auto kSessionPollPeriod = std::chrono::milliseconds(20);

// Names the plug-in in a message on a fault of its device: " (device plugin:./pen.so)". Empty for other devices.
std::string name_plugin(const IoOptions& options) {
  const std::string& name = options.device.name;
  return name.starts_with(kPluginDevice) ? fmt::format(" (device {})", name) : std::string();
}

// Largest share of a period for which the network side spins while it waits for a force.
double find_reply_share(const IoOptions& options) { return std::min(1e-6 * options.reply_spin_us * options.rate_hz, ReplySpin::kMaxShare); }

// Text on the round trip, from which --touch auto chooses where forces are computed.
std::string describe_round_trip(double seconds) {
  return seconds > 0.0 ? fmt::format("touch, round trip {:.1f} ms", 1e3 * seconds) : "touch, round trip not known yet";
}

std::string describe_fault(const ServoEvent& event, const IoOptions& options) {
  switch (event.kind) {
    case ServoEvent::Kind::latched:
      return fmt::format("fault latched, no force: {}{}; fix the cause, then: hapton set --reset-faults (docs/safety.md)",
                         describe(event.fault), name_plugin(options));
    case ServoEvent::Kind::reset:
      return fmt::format("fault reset ({}); the force ramps up", to_string(event.fault));
    case ServoEvent::Kind::reset_rejected:
      return fmt::format("fault not reset: its cause persists: {}{}", describe(event.fault), name_plugin(options));
    case ServoEvent::Kind::reset_without_right:
      return fmt::format("fault reset rejected: the tool at {} has no operator's key (hapton keygen --role operator)",
                         to_string(event.address));
    case ServoEvent::Kind::reset_without_person:
      return fmt::format(
          "fault reset rejected: the operator at {} is on another host and no dead man's switch is held; reset it here, or while someone "
          "holds the switch (--dead-mans-switch)",
          to_string(event.address));
    default:
      return {};
  }
}

// Text on a node, or a sender of datagrams, that was rejected.
std::string describe_rejection(const ServoEvent& event) {
  switch (event.kind) {
    case ServoEvent::Kind::rejected:
      return fmt::format("a {} node was rejected: the hub has no free slot for it; it keeps trying", name_of(event.role));
    case ServoEvent::Kind::wrong_key:
      return "a node with another key, or none, tried to join; if it is yours, give it a key made from this hub's master key: "
             "hapton keygen --role ROLE --master MASTER FILE";
    case ServoEvent::Kind::wrong_version:
      return "a node uses another protocol version; if it is yours, build all nodes from the same sources, and make new keys "
             "(hapton keygen) if it is older than version 3";
    case ServoEvent::Kind::role_violation:
      return "a node requested a role that its key does not allow; if it is yours, give it the key of its role: hapton keygen "
             "--role ROLE --master MASTER FILE";
    case ServoEvent::Kind::flood:
      return fmt::format("flood of {} from {}{}, {:.0f} a second: {}; the force is not delayed", describe(event.flood),
                         to_string(event.address), event.is_from_several ? " and others" : "", event.rate_hz,
                         event.is_mostly_filtered ? "dropped in the kernel (nodes may take longer to join)" : "rejected");
    default:
      return {};
  }
}

std::string describe(const ServoEvent& event, const IoOptions& options) {
  switch (event.kind) {
    case ServoEvent::Kind::joined:
      return fmt::format("{} joined from {}", name_of(event.role), to_string(event.address));
    case ServoEvent::Kind::left:
      return fmt::format("{} at {} left", name_of(event.role), to_string(event.address));
    case ServoEvent::Kind::rejected:
    case ServoEvent::Kind::wrong_key:
    case ServoEvent::Kind::wrong_version:
    case ServoEvent::Kind::role_violation:
    case ServoEvent::Kind::flood:
      return describe_rejection(event);
    case ServoEvent::Kind::latched:
    case ServoEvent::Kind::reset:
    case ServoEvent::Kind::reset_rejected:
    case ServoEvent::Kind::reset_without_right:
    case ServoEvent::Kind::reset_without_person:
      return describe_fault(event, options);
    case ServoEvent::Kind::rate_changed:
      return fmt::format("servo rate now {:.0f} Hz", event.rate_hz);
    case ServoEvent::Kind::method_requested:
      return fmt::format("method requested: {}", text_of(event.method));
    case ServoEvent::Kind::material_requested:
      return "change of a material requested";
    case ServoEvent::Kind::out_of_reach:
      return "the scene is out of the device's reach: give its --unit, place it with a scene file (docs/scene-files.md), or leave out "
             "--no-fit";
    case ServoEvent::Kind::too_small:
      return "the scene is far too small for the device's workspace: give its --unit, scale it in a scene file, or leave out --no-fit";
    case ServoEvent::Kind::parts_requested:
      return fmt::format("{}: requesting the scene in parts, to compute the force here (docs/remote.md)",
                         describe_round_trip(event.round_trip_s));
    case ServoEvent::Kind::force_from_parts:
      return "touch: the force is computed here, from parts of the scene";
    case ServoEvent::Kind::force_from_haptics:
      return fmt::format("{}: the force comes from haptics_node again", describe_round_trip(event.round_trip_s));
    case ServoEvent::Kind::in_reach:
      return "the scene is within the device's reach";
    case ServoEvent::Kind::away:
      return "the device is disconnected; no force until it is back";
    case ServoEvent::Kind::calibrating:
      return "the device is being calibrated; no force until it is ready";
    case ServoEvent::Kind::back:
      return "the device is ready; the force ramps up";
  }
  return {};
}

// False: the device has stopped for good. A device that is unplugged or being calibrated can become ready again.
bool may_become_ready(DeviceStatus status) { return status != DeviceStatus::ended && status != DeviceStatus::fault; }

std::string_view main_cause(const ServoStats& stats) {
  const auto most = std::max_element(stats.missed_by_cause.begin(), stats.missed_by_cause.end());
  return to_string(static_cast<MissCause>(most - stats.missed_by_cause.begin()));
}

}  // namespace

IoSession::IoSession(NetworkLoop& network, const Clock& clock, const IoOptions& options)
    : network_(network),
      clock_(clock),
      options_(options),
      prefix_(name_prefix(options)),
      device_thread_(network.device_loop(), clock),
      stale_force_watchdog_(network.device_loop(), clock),
      scheduling_monitor_(options.spin_share + find_reply_share(options), read_realtime_share()) {}

void IoSession::run_network() {
  network_thread_id_ = current_thread_id();
  ::pthread_setname_np(::pthread_self(), "hapton-network");
  const auto realtime = enter_realtime(options_.realtime);
  if (realtime) {
    realtime_ = realtime->to_text();
    realtime_lines_ = realtime->to_lines();
  } else {
    started_ = tl::unexpected(realtime.error());
  }
  if (realtime) network_.start();
  is_started_.store(true, std::memory_order_release);
  if (realtime) {
    while (!ends_.load(std::memory_order_relaxed) && may_become_ready(network_.device_status()) && !network_.has_overrun()) network_.step();
    network_.finish();
  }
  has_ended_.store(true, std::memory_order_release);
}

bool IoSession::is_over(const StopSignal& stop) const {
  return stop.stop_requested() || clock_.now_ns() >= end_ns_ || has_ended_.load(std::memory_order_acquire);
}

Result<void> IoSession::run(const StopSignal& stop) {
  network_.use_device_thread();
  if (auto begun = device_thread_.start(options_.realtime); !begun) return begun;
  stale_force_watchdog_.start(options_.realtime.mode != RealtimeMode::off);
  std::thread network = start_thread([this] { run_network(); });
  while (!is_started_.load(std::memory_order_acquire)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  end_ns_ = options_.seconds > 0.0 ? clock_.now_ns() + static_cast<std::int64_t>(1e9 * options_.seconds)
                                   : std::numeric_limits<std::int64_t>::max();
  Result<void> reported = started_ ? supervise(stop) : started_;
  ends_.store(true, std::memory_order_relaxed);
  network.join();
  print_events();  // keeps a latched fault before the rest, which may take seconds
  device_thread_.stop();
  network_.record_remaining_cycles();
  stale_force_watchdog_.stop();
  print_events();
  if (!started_) return started_;
  const ServoStats& stats = network_.collect_stats();
  print_text("{}", described(stats));
  if (const auto last = write_report_of(stats); reported && !last) reported = last;
  if (network_.device_status() == DeviceStatus::fault)
    return fail("the device{} stopped replying; check its cable and power", name_plugin(options_));
  if (network_.has_overrun()) {
    return fail("a cycle was missed ({}) and --overrun is stop; allow the loop real time (--rt), or set a lower --rate", main_cause(stats));
  }
  return reported;
}

Result<void> IoSession::supervise(const StopSignal& stop) {
  Result<void> reported;
  log_info("{}{}", prefix_, realtime_lines_.front());
  if (device_thread_.realtime_lines().front() != realtime_lines_.front())
    log_info("{}device loop, {}", prefix_, device_thread_.realtime_lines().front());
  for (std::size_t n = 1; n < realtime_lines_.size(); ++n) log_warning("{}{}", prefix_, realtime_lines_[n]);
  while (!is_over(stop)) {
    std::this_thread::sleep_for(kSessionPollPeriod);
    print_events();
    watch_scheduling(clock_.now_ns() >= next_scheduling_check_ns_);
    notify_service();
    note_requests(stop);
    if (!network_.take_snapshot()) continue;
    if (const auto granted = serve_requests(network_.snapshot()); !granted && reported) reported = granted;
  }
  // This session may take seconds to end; it must not count as hung while the loops of other devices run.
  if (service_ != nullptr) service_->leave(service_number_);
  return reported;
}

// Reports once that the loops come near the kernel's limit: above the limit the kernel stops them for the rest of each of its periods.
void IoSession::watch_scheduling(bool is_due) {
  if (!is_due) return;
  next_scheduling_check_ns_ = clock_.now_ns() + kWatchEveryNs;
  check_watchdog();
  // The sum of both threads: the kernel limits the real-time threads of each CPU, and the two may share one.
  auto usage = read_thread_usage(network_thread_id_);
  const auto device = read_thread_usage(device_thread_.id());
  if (!usage || !device) return;
  usage->run_s += device->run_s;
  usage->waited_s += device->waited_s;
  usage->voluntary_switches += device->voluntary_switches;
  usage->involuntary_switches += device->involuntary_switches;
  const double limit = scheduling_monitor_.update(*usage, network_.spin().spun_ns() + network_.reply_spin().spun_ns(), clock_.now_ns());
  // The spin that keeps ticks on time comes first; the spin for replies gets what is left.
  network_.spin().set_limit(std::min(limit, options_.spin_share));
  network_.reply_spin().set_limit(std::max(0.0, limit - options_.spin_share));
  if (scheduling_monitor_.has_come_near_throttling()) {
    log_warning("{}the servo loop uses nearly all the CPU time that the kernel allows real-time threads ({:.0f} %); lower --rate", prefix_,
                100.0 * scheduling_monitor_.stats().realtime_share);
  }
}

void IoSession::check_watchdog() {
  if (watchdog_ == nullptr) return;
  if (const auto restarted = watchdog_->restart_if_dead(clock_.now_ns())) {
    log_warning("{}the watchdog process had ended or hung, and {}; find out why: without it nothing releases the force of a frozen io_node",
                prefix_, *restarted ? "was restarted" : "could not be restarted: " + restarted->error().what);
  }
  const std::uint64_t cuts_before = std::exchange(cuts_reported_, watchdog_->cuts());
  if (cuts_reported_ != cuts_before) {
    log_warning("{}the watchdog process released the force: this program hung or held a force too long; see hapton doctor", prefix_);
  }
}

void IoSession::notify_service() {
  if (service_ == nullptr || !service_->has_manager() || clock_.now_ns() < next_liveness_ns_) return;
  const std::int64_t timeout_ns = service_->manager_timeout_ns();
  next_liveness_ns_ = clock_.now_ns() + (timeout_ns > 0 ? std::min(kWatchEveryNs, timeout_ns / 2) : kWatchEveryNs);
  const bool is_alive = clock_.now_ns() - network_.device_loop().heartbeat_ns() < kWatchEveryNs;
  service_->note(service_number_, is_alive, clock_.now_ns());
}

void IoSession::note_requests(const StopSignal& stop) {
  const bool requested_by_tool = network_.take_report_request();
  const bool requested_by_reader = report_server_ != nullptr && report_server_->take_request();
  is_scraped_ = is_scraped_ || (metrics_ != nullptr && metrics_->take_request());
  const bool metrics_due = is_scraped_ && clock_.now_ns() >= next_metrics_ns_;
  const std::uint32_t requested_before = std::exchange(reports_requested_, stop.report_requests());
  const bool requested_by_signal = reports_requested_ != requested_before;
  if (!requested_by_tool && !requested_by_reader && !metrics_due && !requested_by_signal) return;
  file_requested_ = file_requested_ || requested_by_tool || requested_by_signal;
  server_wants_report_ = server_wants_report_ || requested_by_reader;
  metrics_requested_ = metrics_requested_ || metrics_due;
  if (metrics_due) {
    is_scraped_ = false;
    next_metrics_ns_ = clock_.now_ns() + kMinMetricsPeriodNs;
  }
  network_.request_snapshot();
}

Result<void> IoSession::serve_requests(const ServoStats& stats) {
  const bool writes_file = std::exchange(file_requested_, false);
  const bool fills_server = std::exchange(server_wants_report_, false);
  const bool fills_metrics = std::exchange(metrics_requested_, false);
  if (fills_server || fills_metrics) {
    const LatencyReport report = make_io_report(stats, options_, realtime_, scheduling_monitor_.stats());
    if (fills_server) report_server_->publish(to_json(report), to_csv(report));
    if (fills_metrics) metrics_->set_text(to_prometheus(report));
  }
  if (!writes_file) return {};
  const auto written = write_report_of(stats);
  if (written) log_info("{}report on request: {}", prefix_, options_.out.empty() ? "on the terminal only, no --out given" : options_.out);
  if (options_.out.empty()) print_text("{}", described(stats));
  return written;
}

void IoSession::print_events() {
  for (ServoEvent event; network_.events().pop(event);) {
    log_info("{}{}", prefix_, describe(event, options_));
    if (latch_file_ != nullptr) keep_latch(event);
  }
}

// DeviceHub removes the fault `device` again if the process ends by itself.
void IoSession::keep_latch(const ServoEvent& event) {
  if (event.kind == ServoEvent::Kind::reset) latch_file_->forget();
  if (event.kind != ServoEvent::Kind::latched) return;
  if (const auto kept = latch_file_->keep(event.fault); !kept) {
    log_warning("{}the latched fault could not be saved, so a restart would reset it: {}", prefix_, kept.error().what);
  }
}

std::string IoSession::described(const ServoStats& stats) const {
  const std::string run = describe_run(stats, scheduling_monitor_.stats());
  return options_.name.empty() ? run : fmt::format("--- {}\n{}", options_.name, run);
}

Result<void> IoSession::write_report_of(const ServoStats& stats) {
  if (options_.out.empty()) return {};
  return write_report(make_io_report(stats, options_, realtime_, scheduling_monitor_.stats()), options_.out);
}

}  // namespace hapton
