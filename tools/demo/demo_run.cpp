#include "tools/demo/demo_run.h"

#include <system_error>
#include <utility>

#include "runtime/clock.h"
#include "tools/demo/demo_system.h"
#include "tools/latency/latency_compare.h"
#include "tools/temporary_folder.h"

namespace hapton {
namespace {

// A scripted step waits for its picture up to this many times its duration, for a large mesh or a busy machine.
constexpr double kPictureTimeFactor = 5.0;
constexpr double kKillShare = 0.6;      // share of a scripted step before the node is killed: the hand is at rest by then
constexpr double kPictureDelayS = 1.0;  // the picture is taken this long after the node was killed
constexpr double kKillAfterS = 5.0;     // in a window: from the beginning of a cycle until the node is killed
constexpr double kRestartAfterS = 8.0;  // from the beginning of a cycle until the restart; leaves 3 s without force to look at
constexpr double kKillEveryS = 12.0;    // duration of a cycle; these times are free choices

class Stopwatch {
 public:
  double seconds() const { return 1e-9 * static_cast<double>(now_ns() - start_ns_); }
  static std::int64_t now_ns() { return SteadyClock().now_ns(); }

 private:
  std::int64_t start_ns_ = now_ns();
};

// Waits until the condition holds. Returns false if the time is over first. Error: a node has ended, or a stop was requested.
template <class Condition>
Result<bool> wait_until(DemoSystem& system, const StopSignal& stop, double at_most_s, Condition&& holds) {
  SteadyClock clock;
  for (const Stopwatch watch; !holds();) {
    if (stop.stop_requested()) return fail("stopped");
    if (const auto running = system.check_running(); !running) return tl::unexpected(running.error());
    if (watch.seconds() > at_most_s) return false;
    clock.sleep_until_ns(clock.now_ns() + 50 * kNanosecondsPerMillisecond);
  }
  return true;
}

Result<bool> wait_for(DemoSystem& system, const StopSignal& stop, double seconds) {
  return wait_until(system, stop, seconds, [] { return false; });
}

Result<bool> wait_for_picture(DemoSystem& system, const StopSignal& stop, double at_most_s, const std::filesystem::path& picture) {
  return wait_until(system, stop, at_most_s, [&] {
    std::error_code error;
    return std::filesystem::exists(picture, error);
  });
}

// The picture shows the moment `picture_at` of the step or, if that does not come, the end.
Result<void> play(const DemoStep& step, DemoSystem& system, const StopSignal& stop, double seconds, const std::filesystem::path& picture) {
  if (const auto started = system.start_vision(step); !started) return started;
  if (const auto waited = wait_for(system, stop, seconds); !waited) return tl::unexpected(waited.error());
  const auto taken = wait_for_picture(system, stop, kPictureTimeFactor * seconds, picture);
  return taken ? Result<void>() : tl::unexpected(taken.error());
}

// The picture shows what a user sees without the haptics node. The vision node is started before the haptics node is killed: a new vision
// node may have turned the scene, and then the contact is not resumed.
Result<void> play_death(const DemoStep& step, DemoSystem& system, const StopSignal& stop, double seconds,
                        const std::filesystem::path& picture, DemoEvidence& evidence) {
  if (const auto started = system.start_vision(step); !started) return started;
  if (const auto waited = wait_for(system, stop, kKillShare * seconds); !waited) return tl::unexpected(waited.error());
  evidence.killed_ns = Stopwatch::now_ns();
  system.kill_haptics();
  if (const auto taken = wait_for_picture(system, stop, kPictureTimeFactor * seconds, picture); !taken)
    return tl::unexpected(taken.error());
  evidence.restarted_ns = Stopwatch::now_ns();
  if (const auto started = system.start_haptics(); !started) return started;
  const auto waited = wait_for(system, stop, (1.0 - kKillShare) * seconds);
  return waited ? Result<void>() : tl::unexpected(waited.error());
}

Result<std::filesystem::path> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  return error ? fail("{}: cannot be made: {}", folder.string(), error.message()) : Result<std::filesystem::path>(folder);
}

}  // namespace

Result<DemoOutcome> run_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop) {
  const DemoStep& step = demo_steps()[number - 1];
  const auto step_folder = make_folder(settings.out / demo_file_name(number));
  const auto scratch = TemporaryFolder::make();
  if (!step_folder || !scratch) return tl::unexpected(step_folder ? scratch.error() : step_folder.error());
  DemoOutcome outcome{.verdict = {}, .picture = settings.out / (demo_file_name(number) + ".png")};
  std::error_code error;
  std::filesystem::remove(outcome.picture, error);
  const bool is_node_killed = step.event == DemoStep::Event::haptics_dies;
  const double seconds = settings.seconds.value_or(kDemoSeconds);
  const std::string picture_moment = is_node_killed ? fmt::format("{}", kKillShare * seconds + kPictureDelayS) : step.picture_at;
  DemoSystem system({.out = *step_folder,
                     .scratch = scratch->path(),
                     .cpu = settings.cpu,
                     .records = true,
                     .vision = {"--offscreen", "--size", "848x480", "--no-keys-help", "--screenshot", outcome.picture.string(),
                                "--screenshot-when", picture_moment}});
  if (const auto started = system.start(step); !started) return tl::unexpected(started.error());
  DemoEvidence evidence;
  const auto played = is_node_killed ? play_death(step, system, stop, seconds, outcome.picture, evidence)
                                     : play(step, system, stop, seconds, outcome.picture);
  if (!played) return tl::unexpected(played.error());
  if (const auto ended = system.stop(); !ended) return tl::unexpected(ended.error());
  if (!std::filesystem::exists(outcome.picture, error))
    return fail("no picture was taken; see {}", (*step_folder / "vision_node.log").string());
  auto motion = read_demo_motion(system.recording());
  auto report = read_report_json(system.report());
  if (!motion || !report) return tl::unexpected(motion ? report.error() : motion.error());
  evidence.motion = std::move(*motion);
  evidence.report = std::move(*report);
  outcome.verdict = step.evaluate(evidence);
  return outcome;
}

std::optional<DemoRequest> find_demo_request(char key) {
  if (key == 'q' || key == 'Q') return DemoRequest{DemoChoice::quit, 0};
  if (key == 'n' || key == 'N' || key == ' ' || key == '\n') return DemoRequest{DemoChoice::next, 0};
  const auto number = static_cast<std::size_t>(key - '0');
  if (key >= '1' && number <= demo_steps().size()) return DemoRequest{DemoChoice::go_to, number};
  return std::nullopt;
}

Result<DemoRequest> watch_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop, KeyReader& keys) {
  const DemoStep& step = demo_steps()[number - 1];
  const auto scratch = TemporaryFolder::make();
  if (!scratch) return tl::unexpected(scratch.error());
  DemoSystem system({.out = scratch->path(), .scratch = scratch->path(), .cpu = settings.cpu, .records = false, .vision = {}});
  if (const auto started = system.start(step); !started) return tl::unexpected(started.error());
  if (const auto started = system.start_vision(step); !started) return tl::unexpected(started.error());
  std::optional<DemoRequest> request;
  Stopwatch since_event;
  bool is_dead = false;
  for (const Stopwatch watch; !request;) {
    if (const auto key = keys.read_key()) request = find_demo_request(*key);
    if (stop.stop_requested() || !system.is_vision_open()) request = DemoRequest{DemoChoice::quit, 0};
    if (!request && settings.seconds && watch.seconds() >= *settings.seconds) request = DemoRequest{DemoChoice::next, 0};
    if (step.event == DemoStep::Event::none || request) continue;
    if (!is_dead && since_event.seconds() > kKillAfterS && since_event.seconds() < kRestartAfterS) {
      system.kill_haptics();
      is_dead = true;
    } else if (is_dead && since_event.seconds() > kRestartAfterS) {
      if (const auto started = system.start_haptics(); !started) return tl::unexpected(started.error());
      is_dead = false;
    } else if (since_event.seconds() > kKillEveryS) {
      since_event = Stopwatch();
    }
  }
  if (request->choice == DemoChoice::quit) return *request;
  const auto ended = system.stop();
  return ended ? Result<DemoRequest>(*request) : tl::unexpected(ended.error());
}

}  // namespace hapton
