#include "tools/set_command.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "link/hub_client.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"

namespace hapton {
namespace {

struct SetOptions {
  std::string hub = "127.0.0.1";
  std::string key_file;
  double rate_hz = 0.0;
  std::string method;
  bool report = false;
};

constexpr std::int64_t kPatienceNs = 2 * kNanosecondsPerSecond;

// Listens to the hub until it holds or patience ends.
template <class Condition>
bool wait_until(HubClient& client, const Clock& clock, Condition&& holds) {
  const std::int64_t end_ns = clock.now_ns() + kPatienceNs;
  Datagram ignored;
  while (!holds()) {
    const std::int64_t now_ns = clock.now_ns();
    if (now_ns >= end_ns) {
      return false;
    }
    client.receive(ignored, now_ns + 20 * kNanosecondsPerMillisecond);
  }
  return true;
}

Result<Settings> make_settings(const SetOptions& options) {
  if (options.rate_hz == 0.0 && options.method.empty() && !options.report) {
    return fail("nothing to set; give --rate, --method or --report");
  }
  Settings settings;
  settings.servo_rate_hz = options.rate_hz;
  settings.report_now = options.report;
  if (!options.method.empty() && (options.method.size() >= settings.method.size() || !is_method_name(options.method))) {
    return fail("method '{}' is not known; choose one of: {}", options.method, method_names());
  }
  std::copy(options.method.begin(), options.method.end(), settings.method.begin());
  return settings;
}

const char* any_address_like(const Address& hub) { return hub.ip[10] == 0xff && hub.ip[11] == 0xff ? "0.0.0.0:0" : "[::]:0"; }

Result<std::string> set(const SetOptions& options) {
  const auto settings = make_settings(options);
  if (!settings) {
    return tl::unexpected(settings.error());
  }
  const auto hub = parse_address(options.hub);
  if (!hub) {
    return tl::unexpected(hub.error());
  }
  const auto key = find_link_key(options.key_file, *hub);
  if (!key) {
    return tl::unexpected(key.error());
  }
  auto endpoint = open_udp_endpoint(any_address_like(*hub));
  if (!endpoint) {
    return tl::unexpected(endpoint.error());
  }
  const SteadyClock clock;
  SealedClient sealed(**endpoint, clock, *key, *hub);
  HubClient client(sealed, clock, NodeRole::tool, *hub);
  if (!wait_until(client, clock, [&] { return client.state() == JoinState::joined; })) {
    return fail("no hub answers at {}; start io_node there, name another place with --hub, or give the hub's --key", to_string(*hub));
  }
  if (!client.send(*settings)) {
    return fail("the settings could not be sent to {}", to_string(*hub));
  }
  const auto rate_holds = [&] {
    return options.rate_hz == 0.0 || std::abs(client.servo_rate_hz() - options.rate_hz) <= 1e-3 * options.rate_hz;
  };
  if (!wait_until(client, clock, rate_holds)) {
    return fail("the hub at {} stays at {} Hz; ask for {} to {} Hz", to_string(*hub), client.servo_rate_hz(), kMinServoRateHz,
                kMaxServoRateHz);
  }
  std::string told = fmt::format("hub {}: servo rate {} Hz", to_string(*hub), client.servo_rate_hz());
  if (!options.method.empty()) {
    told += fmt::format("; method {} asked for, in use as soon as the haptics node has built it", options.method);
  }
  return options.report ? told + "; report asked for" : told;
}

int run(const SetOptions& options) {
  const auto told = set(options);
  if (!told) {
    fmt::print(stderr, "hapton set: {}\n", told.error().what);
    return 1;
  }
  fmt::print("{}\n", *told);
  return 0;
}

}  // namespace

void add_set_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SetOptions>();
  CLI::App* command = app.add_subcommand("set", "Change a running system");
  command->add_option("--hub", options->hub, "Where io_node is: HOST or HOST:PORT")->capture_default_str();
  command->add_option("--key", options->key_file, kKeyHelp);
  command->add_option("--rate", options->rate_hz, "Servo rate, Hz")->check(CLI::Range(kMinServoRateHz, kMaxServoRateHz));
  command->add_option("--method", options->method, "Force method, one of: " + method_names());
  command->add_flag("--report", options->report, "Have the latency report written now");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
