#include "tools/latency_run.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/stop_signal.h"
#include "tools/child_process.h"
#include "tools/latency_plot.h"

namespace hapton {
namespace {

constexpr double kLoadSeconds = 120.0;  // for the haptics node to load and divide its scene
constexpr double kGraceSeconds = 15.0;  // for the hub to write its report

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string last_line(const std::filesystem::path& log) {
  std::string text = read_text(log);
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.substr(text.rfind('\n') + 1);
}

Result<std::string> find_free_address() {
  const auto endpoint = open_udp_endpoint("127.0.0.1:0");
  if (!endpoint) {
    return tl::unexpected(endpoint.error());
  }
  return to_string((*endpoint)->local_address());
}

// One of the neighbours of this program, at work on the measurement.
class Node {
 public:
  static Result<Node> start(const LatencyRunOptions& options, const std::string& name, const std::string& program,
                            std::vector<std::string> arguments) {
    const auto log = options.out / (name + ".log");
    auto process =
        ChildProcess::start({.program = find_own_folder() / program, .arguments = std::move(arguments), .folder = {}, .output = log});
    if (!process) {
      return tl::unexpected(process.error());
    }
    return Node(name, log, std::move(*process));
  }

  // Until the text stands in its log.
  Result<void> wait_for(const std::string& text) {
    constexpr double kLookSeconds = 0.05;
    for (double waited = 0.0; waited < kLoadSeconds; waited += kLookSeconds) {
      const auto code = process_.wait(kLookSeconds);
      if (read_text(log_).find(text) != std::string::npos) {
        return {};
      }
      if (code) {
        return failed(*code);
      }
    }
    return fail("{} was not ready after {} s; see {}", name_, kLoadSeconds, log_.string());
  }

  // To its end, which is due after that time.
  Result<void> wait_for_end(double seconds) {
    const auto code = process_.wait(seconds);
    if (!code) {
      return fail("{} did not end; see {}", name_, log_.string());
    }
    return *code == 0 ? Result<void>() : failed(*code);
  }

  Result<void> stop() {
    const int code = process_.stop();
    return code == 0 ? Result<void>() : failed(code);
  }

 private:
  Node(std::string name, std::filesystem::path log, ChildProcess process)
      : name_(std::move(name)), log_(std::move(log)), process_(std::move(process)) {}

  Result<void> failed(int code) const { return fail("{} ended with {}: {}", name_, code, last_line(log_)); }

  std::string name_;
  std::filesystem::path log_;
  ChildProcess process_;
};

Result<void> measure(const LatencyRunOptions& options) {
  const auto echo_at = find_free_address();
  const auto hub_at = find_free_address();
  if (!echo_at || !hub_at) {
    return tl::unexpected(echo_at ? hub_at.error() : echo_at.error());
  }
  const std::string cpu = fmt::format("{}", options.cpu);
  // Scheduled as the nodes are: else their ratio would tell of the scheduler.
  auto echo = Node::start(options, "echo", "hapton", {"echo", "--bind", *echo_at, "--rt", options.realtime, "--cpu", cpu});
  if (!echo) {
    return tl::unexpected(echo.error());
  }
  std::vector<std::string> arguments = {"--hub", *hub_at, "--scene", options.scene.string(), "--rt", options.realtime, "--cpu", cpu};
  if (!options.method.empty()) {
    arguments.insert(arguments.end(), {"--method", options.method});
  }
  auto haptics = Node::start(options, "haptics_node", "haptics_node", std::move(arguments));
  if (!haptics) {
    return tl::unexpected(haptics.error());
  }
  for (const auto& ready : {echo->wait_for("echo at"), haptics->wait_for("ready")}) {
    if (!ready) {
      return ready;
    }
  }
  auto io = Node::start(options, "io_node", "io_node",
                        {"--bind", *hub_at, "--echo-probe", *echo_at, "--rate", fmt::format("{}", options.rate_hz), "--seconds",
                         fmt::format("{}", options.seconds), "--out", options.out.string(), "--rt", options.realtime, "--cpu", cpu});
  if (!io) {
    return tl::unexpected(io.error());
  }
  for (const auto& ended : {io->wait_for_end(options.seconds + kGraceSeconds), haptics->stop(), echo->stop()}) {
    if (!ended) {
      return ended;
    }
  }
  return {};
}

Result<std::string> tell(const std::filesystem::path& file) {
  const auto json = nlohmann::json::parse(read_text(file), nullptr, false);
  if (!json.is_object() || !json.contains("hops") || !json["hops"].is_object()) {
    return fail("{}: is no latency report", file.string());
  }
  std::string text = fmt::format("{:<18} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "us", "n", "p50", "p90", "p99", "p99.9", "max");
  for (const auto& [name, hop] : json["hops"].items()) {
    if (hop.value("n", 0) > 0) {
      text += fmt::format("{:<18} {:>8} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f}\n", name, hop.value("n", 0), hop.value("p50_us", 0.0),
                          hop.value("p90_us", 0.0), hop.value("p99_us", 0.0), hop.value("p99_9_us", 0.0), hop.value("max_us", 0.0));
    }
  }
  const auto ratios = json.value("ratios", nlohmann::json::object());
  if (!ratios.contains("round_trip_over_echo_p50")) {
    return fail("{}: no force or no echo was measured; see the logs beside it", file.string());
  }
  const auto counters = json.value("counters", nlohmann::json::object());
  text += fmt::format("{} samples, {} forces, {} in contact, {} late, {} lost\n", counters.value("samples", 0), counters.value("forces", 0),
                      counters.value("contact_samples", 0), counters.value("late", 0), counters.value("lost", 0));
  return text + fmt::format("force round trip over bare echo of the same run: p50 {:.2f} x, p99 {:.2f} x\n",
                            ratios.value("round_trip_over_echo_p50", 0.0), ratios.value("round_trip_over_echo_p99", 0.0));
}

}  // namespace

Result<std::string> run_latency(const LatencyRunOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) {
    return fail("{}: cannot be made: {}", options.out.string(), error.message());
  }
  if (!std::filesystem::exists(options.scene)) {
    return fail("{}: there is no such scene here; name one with --scene", options.scene.string());
  }
  // An interrupt reaches the nodes as well: they end, the hub writes what it has, and that is reported.
  const StopSignal interrupts;
  if (const auto measured = measure(options); !measured) {
    return tl::unexpected(measured.error());
  }
  auto text = tell(options.out / "report.json");
  if (text) {
    const auto picture = draw_latency_plot(options.out);
    *text += fmt::format("report in {}; {}\n", options.out.string(), picture ? "plot in " + picture->string() : picture.error().what);
  }
  return text;
}

}  // namespace hapton
