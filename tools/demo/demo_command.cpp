#include <fmt/core.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atomic_file.h"
#include "runtime/realtime.h"
#include "runtime/stop_signal.h"
#include "tools/child_process.h"
#include "tools/commands.h"
#include "tools/demo/demo_run.h"
#include "tools/local_node.h"

namespace hapton {
namespace {

struct DemoOptions {
  std::size_t only = 0;  // 0: all
  std::optional<double> seconds;
  std::string out = "out/demo";
  bool list = false;
  bool headless = false;
};

std::string step_text(std::size_t number) {
  const DemoStep& step = demo_steps()[number - 1];
  return fmt::format("{}  {}\n{}\n", number, step.name, step.watch_for);
}

void list_steps() {
  for (std::size_t number = 1; number <= demo_steps().size(); ++number) fmt::print("{}\n", step_text(number));
}

Result<void> check_programs() {
  for (const char* program : {"io_node", "haptics_node", "vision_node"}) {
    const auto path = find_own_folder() / program;
    std::error_code error;
    if (!std::filesystem::exists(path, error)) {
      return fail("{} is not there; {}", path.string(),
                  std::string(program) == "vision_node" ? "install hapton-vision, or build it (deploy/build)" : "build it (deploy/build)");
    }
  }
  return {};
}

// The requested steps, first and last.
std::pair<std::size_t, std::size_t> range_of(const DemoOptions& options) {
  return options.only == 0 ? std::pair<std::size_t, std::size_t>(1, demo_steps().size()) : std::pair(options.only, options.only);
}

// True if every step showed what it promises.
Result<bool> run_by_script(const DemoOptions& options, const DemoSettings& settings) {
  const StopSignal stop;
  std::error_code error;
  std::filesystem::create_directories(settings.out, error);
  if (error) return fail("{}: cannot be made: {}", settings.out.string(), error.message());
  LocalDisplay display;
  if (const auto shown = display.start_if_none(settings.out); !shown) return tl::unexpected(shown.error());
  bool all_shown = true;
  std::string lines;
  const auto [first, last] = range_of(options);
  for (std::size_t number = first; number <= last; ++number) {
    const auto outcome = run_demo_step(number, settings, stop);
    if (!outcome && stop.stop_requested()) return tl::unexpected(outcome.error());
    const std::string name = fmt::format("{} {}", number, demo_steps()[number - 1].name);
    const std::string line =
        outcome ? fmt::format("{}: {}; {}\n", name, outcome->verdict.is_shown ? "shown" : "NOT SHOWN", outcome->verdict.text)
                : fmt::format("{}: NOT SHOWN; {}\n", name, outcome.error().what);
    all_shown = all_shown && outcome && outcome->verdict.is_shown;
    lines += line;
    fmt::print("{}", line);
    std::fflush(stdout);
  }
  if (const auto written = write_file_atomically(settings.out / "demo.txt", lines); !written) return tl::unexpected(written.error());
  fmt::print("pictures, reports and logs are in {}\n", settings.out.string());
  return all_shown;
}

Result<bool> run_in_window(const DemoOptions& options, const DemoSettings& settings) {
  if (std::getenv("DISPLAY") == nullptr) return fail("no DISPLAY is set; --headless runs the tour by script and saves pictures");
  const StopSignal stop;
  KeyReader keys;
  if (!keys.is_terminal() && !settings.seconds)
    return fail("stdin is not a terminal, so no key can be read; give --seconds N, or --headless");
  fmt::print("Keys in this terminal: 1 to {} go to a step, n or Enter to the next one, q quits.\n\n", demo_steps().size());
  auto [number, last] = range_of(options);
  while (number <= last) {
    fmt::print("{}\n", step_text(number));
    std::fflush(stdout);
    const auto request = watch_demo_step(number, settings, stop, keys);
    if (!request) return tl::unexpected(request.error());
    if (request->choice == DemoChoice::quit) break;
    number = request->choice == DemoChoice::go_to ? request->number : number + 1;
    last = request->choice == DemoChoice::go_to ? demo_steps().size() : last;
  }
  return true;
}

// If the user closes the terminal of a menu entry, this is a request to stop, as Ctrl-C is, so that no process stays behind.
void stop_at_hangup() {
  std::signal(SIGHUP, [](int) { std::raise(SIGTERM); });
}

int run(const DemoOptions& options) {
  if (options.list) {
    list_steps();
    return 0;
  }
  stop_at_hangup();
  const DemoSettings settings{.out = options.out, .seconds = options.seconds, .cpu = find_shared_cpu()};
  Result<bool> shown = false;
  if (const auto there = check_programs(); !there) {
    shown = tl::unexpected(there.error());
  } else {
    shown = options.headless ? run_by_script(options, settings) : run_in_window(options, settings);
  }
  if (!shown) fmt::print(stderr, "hapton demo: {}\n", shown.error().what);
  return shown && *shown ? 0 : 1;
}

}  // namespace

void add_demo_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<DemoOptions>();
  const CommandLine command = app.add_subcommand("demo", "Take a tour without hardware: six things to touch and to look at");
  command.add_flag("--list", options->list, "Show the steps and end");
  command.add_option("--only", options->only, "Only the step with this number").between(std::size_t{1}, demo_steps().size());
  command.add_flag("--headless", options->headless,
                   "Run by script, without display and keys; exit code 0: every step showed what it should");
  command
      .add_option("--seconds", options->seconds,
                  fmt::format("Duration of each step, s (--headless: {:g}; in a window: until a key)", kDemoSeconds))
      .between(kMinDemoSeconds, 1e6);
  command.add_option("--out", options->out, "With --headless: folder for pictures, reports and logs").folder_to_write().shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
