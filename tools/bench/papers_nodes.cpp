#include "tools/bench/papers_nodes.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "runtime/realtime.h"
#include "tools/json_number.h"
#include "tools/latency/latency_compare.h"
#include "tools/latency/latency_run.h"
#include "tools/local_node.h"

namespace hapton {
namespace {

constexpr double kDrawTimeoutS = 300.0;  // limit for drawing all frames; enough for software rendering on a slow machine

// Returns the frames drawn in a second. line: set to the last line that vision_node printed.
Result<double> draw_frames(const PapersNodesSettings& settings, bool culls, LocalVision& vision, std::string& line) {
  std::vector<std::string> arguments = {"--scene",      settings.scene.string(), "--stereo",
                                        "side_by_side", "--bench-frames",        fmt::format("{}", settings.frames)};
  arguments.emplace_back(culls ? "--cull-open" : "--no-cull");
  const auto folder = settings.out / (culls ? "stereo_culled" : "stereo_unculled");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  if (auto started = vision.start(folder, std::move(arguments)); !started) return tl::unexpected(started.error());
  if (auto ended = vision.node().wait_for_end(kDrawTimeoutS); !ended) return tl::unexpected(ended.error());
  line = vision.node().last_line();
  const auto rate = parse_bench_rate(line);
  if (!rate) return fail("vision_node printed no rate; see {}/vision_node.log", folder.string());
  return *rate;
}

void measure_stereo(const PapersNodesSettings& settings, LocalVision& vision, PapersReport& report) {
  for (const bool culls : {true, false}) {
    PaperRow& row = report.row(culls ? kStereoCulled : kStereoUnculled);
    std::string line;
    const auto rate = draw_frames(settings, culls, vision, line);
    if (rate) row.ours = *rate;
    row.how =
        rate ? fmt::format("vision_node {}; {}", culls ? "--cull-open" : "--no-cull", line) : "could not be measured: " + rate.error().what;
  }
}

std::optional<double> hop_ms(const nlohmann::ordered_json& report, const char* hop) {
  const auto hops = report.value("hops", nlohmann::ordered_json::object());
  if (json_number_of(hops, hop, "n") == 0.0) return std::nullopt;
  return 1e-3 * json_number_of(hops, hop, "p50_us");
}

// Once with all nodes; if that fails, once without vision, so that the round trip at least is measured.
void measure_latencies(const PapersNodesSettings& settings, PapersReport& report) {
  LatencyRunOptions run_options;
  run_options.seconds = settings.seconds;
  run_options.out = settings.out / "latency";
  run_options.scene = settings.scene;
  run_options.cpu = find_shared_cpu();
  run_options.vision = true;
  auto run_result = run_latency(run_options);
  PaperRow& round_trip = report.row(kRoundTrip);
  PaperRow& system = report.row(kSystemLatency);
  if (!run_result) {
    system.how = "could not be measured: " + run_result.error().what;
    run_options.vision = false;
    run_options.out = settings.out / "latency_without_vision";
    run_result = run_latency(run_options);
  }
  const auto json = run_result ? read_report_json(run_options.out) : tl::unexpected(run_result.error());
  if (!json) {
    round_trip.how = "could not be measured: " + json.error().what;
    if (run_options.vision) system.how = round_trip.how;
    return;
  }
  round_trip.ours = hop_ms(*json, "round_trip");
  round_trip.how =
      fmt::format("p50, device sample taken to force ready to write, {:g} s at {:g} Hz, {} on one host, sealed UDP over loopback",
                  run_options.seconds, run_options.rate_hz, run_options.vision ? "all three nodes" : "io_node and haptics_node");
  if (!round_trip.ours) round_trip.how = "no force came back; see " + (run_options.out / "report.json").string();
  if (!run_options.vision) return;
  system.ours = hop_ms(*json, "motion_to_photon");
  system.how = system.ours
                   ? "p50 of motion_to_photon in the same run: device sample taken to vision_node having drawn the frame that shows it; "
                     "the display's own delay is not in it"
                   : "vision_node drew no frame; see " + (run_options.out / "vision_node.log").string();
}

}  // namespace

void measure_paper_nodes(const PapersNodesSettings& settings, PapersReport& report) {
  LocalVision vision;  // keeps a virtual display for both measurements, if one is needed
  measure_stereo(settings, vision, report);
  measure_latencies(settings, report);
}

}  // namespace hapton
