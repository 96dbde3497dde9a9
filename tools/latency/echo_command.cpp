#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "link/bare_echo_endpoint.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "runtime/realtime.h"
#include "runtime/stop_signal.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct EchoOptions {
  std::string bind;
  double seconds = 0.0;
  std::string realtime = "off";
  int cpu = -1;
};

int run(const EchoOptions& options) {
  auto echo = BareEchoEndpoint::open(options.bind);
  if (!echo) {
    fmt::print(stderr, "hapton echo: {}\n", echo.error().what);
    return 1;
  }
  const auto realtime = enter_realtime({.mode = *parse_realtime_mode(options.realtime), .cpu = options.cpu});
  if (!realtime) {
    fmt::print(stderr, "hapton echo: {}\n", realtime.error().what);
    return 1;
  }
  fmt::print("echo at {}; {}\n", to_string(echo->local_address()), realtime->to_text());
  std::fflush(stdout);
  const StopSignal stop;
  const SteadyClock clock;
  const double end_ns = static_cast<double>(clock.now_ns()) + 1e9 * options.seconds;
  while (!stop.stop_requested() && (options.seconds <= 0.0 || static_cast<double>(clock.now_ns()) < end_ns)) {
    echo->serve_one();
  }
  fmt::print("{} datagrams returned, {} others ignored\n", echo->served(), echo->ignored());
  return 0;
}

}  // namespace

void add_echo_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<EchoOptions>();
  const CommandLine command =
      app.add_subcommand("echo", "Return every echo request to its sender: the bare round trip of machine and network");
  command.add_option("--bind", options->bind, "ADDRESS:PORT to listen at; port 0 takes a free one").required();
  command.add_option("--seconds", options->seconds, "End after this long, s; 0: when stopped (Ctrl-C)").between(0.0, 1e9).shows_default();
  command.add_option("--rt", options->realtime, "Real-time scheduling, as the nodes have it: try, require or off")
      .one_of({"try", "require", "off"})
      .shows_default();
  command.add_option("--cpu", options->cpu, "Pin to this CPU, unless --rt is off; -1: any").between(-1, 4095).shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
