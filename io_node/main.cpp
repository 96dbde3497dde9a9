#include <fmt/core.h>
#include <malloc.h>

#include <cstdio>
#include <memory>

#include "io_node/device_maker.h"
#include "io_node/io_options.h"
#include "io_node/io_session.h"
#include "io_node/session_recorder.h"
#include "io_node/session_setup.h"
#include "link/link_key.h"
#include "link/metered_endpoint.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/cpu_check.h"
#include "runtime/log.h"
#include "runtime/stop_signal.h"

namespace {

using namespace hapton;

int give_up(const Error& error) {
  log_error("{}", error.what);
  return 1;
}

// The bare echo's own socket and what measures with it; empty when it is not asked for.
struct Echo {
  std::unique_ptr<Endpoint> endpoint;
  std::unique_ptr<EchoProbe> probe;
};

Result<Echo> open_echo(const IoOptions& options, const Clock& clock) {
  Echo echo;
  if (options.echo_probe.empty()) return echo;
  const auto responder = parse_address(options.echo_probe);
  if (!responder) return tl::unexpected(responder.error());
  auto endpoint = open_udp_endpoint(responder->ip[10] == 0xff && responder->ip[11] == 0xff ? "0.0.0.0:0" : "[::]:0");
  if (!endpoint) return tl::unexpected(endpoint.error());
  echo.endpoint = std::move(*endpoint);
  echo.probe = std::make_unique<EchoProbe>(*echo.endpoint, clock, *responder, options.echo_bytes);
  return echo;
}

OverrunPolicy overrun_policy(const IoOptions& options) {
  if (options.overrun == "catch-up") return OverrunPolicy::catch_up;
  return options.overrun == "stop" ? OverrunPolicy::stop : OverrunPolicy::skip;
}

void print_recording(const IoOptions& options, const SessionRecorder::Counts& counts) {
  if (!options.record.empty()) {
    fmt::print("recorded {} entries, {:.1f} MB, {} dropped: {}\n", counts.entries, 1e-6 * static_cast<double>(counts.file_bytes),
               counts.dropped, options.record);
  }
  if (counts.flights + counts.flights_left_out > 0) {
    fmt::print("faults: {} flight records written, {} more faults left out\n", counts.flights, counts.flights_left_out);
  }
}

// Null when nobody wants them.
Result<std::unique_ptr<MetricsEndpoint>> open_metrics(const IoOptions& options) {
  if (options.metrics.empty()) return std::unique_ptr<MetricsEndpoint>();
  auto metrics = MetricsEndpoint::open(options.metrics);
  if (metrics) log_info("metrics at http://{}/metrics", to_string((*metrics)->local_address()));
  return metrics;
}

int run(const IoOptions& options) {
  StopSignal stop;
  SteadyClock clock;
  const auto device = make_device(options.device);
  if (!device) return give_up(device.error());
  const auto address = parse_address(options.bind);
  if (!address) return give_up(address.error());
  const auto key = find_link_key(options.key_file, *address);
  if (!key) return give_up(key.error());
  const auto endpoint = open_udp_endpoint(options.bind);
  if (!endpoint) return give_up(endpoint.error());
  const auto echo = open_echo(options, clock);
  if (!echo) return give_up(echo.error());
  const auto metrics = open_metrics(options);
  if (!metrics) return give_up(metrics.error());

  MeteredEndpoint metered(**endpoint, clock);
  SealedHub sealed(metered, clock, *key);
  const std::uint64_t session_id = make_random_id();
  SessionRecorder::Options recording{options.record, find_flight_folder(options)};
  recording.makes_flight_folder = !options.flight.empty();
  SessionRecorder recorder(recording, make_session_header(options, session_id, clock), clock);
  ServoTap* tap = recording.record.empty() && recording.flight_folder.empty() ? nullptr : &recorder;
  HubPeers peers(sealed, clock, session_id, options.rate_hz);
  const Servo::Options limits{options.rate_hz,         options.vision_rate_hz, options.device.max_force_n, options.device.max_slew_n_per_s,
                              overrun_policy(options), options.spin_share};
  const auto servo = std::make_unique<Servo>(**device, peers, clock, limits, echo->probe.get(), tap);
  fmt::print("hub on {}, device {}, {:g} Hz, at most {:.2f} N, seed {}\n", to_string((*endpoint)->local_address()), (*device)->name(),
             options.rate_hz, servo->force_limits().max_force_n, options.device.seed);
  std::fflush(stdout);
  if (options.device.max_force_n > (*device)->limits().max_force_n ||
      options.device.max_slew_n_per_s > (*device)->limits().max_slew_n_per_s)
    log_warning("limits can only be tightened: the device's own hold, {:.2f} N and {:.0f} N/s", (*device)->limits().max_force_n,
                (*device)->limits().max_slew_n_per_s);
  WayMeter ways(metered);
  ReportDesk desk;
  servo->set_way_meter(&ways);
  servo->set_report_desk(&desk);
  IoSession session(*servo, clock, options);
  session.set_report_desk(&desk);
  session.set_metrics(metrics->get());
  if (const auto started = recorder.start(); !started) return give_up(started.error());
  const auto ended = session.run(stop);
  const auto recorded = recorder.stop();
  print_recording(options, recorder.counts());
  if (!recorded) log_error("{}", recorded.error().what);
  if (!ended) return give_up(ended.error());
  return recorded ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  // What is large, as a flight record in the making is, goes back to the system when it is done with: glibc would raise this limit with the
  // first.
  ::mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  check_cpu("io_node");
  start_log("io_node");
  const auto parsed = parse_io_options(argc, argv);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  return run(std::get<IoOptions>(parsed));
}
