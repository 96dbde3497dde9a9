#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "link/link_key.h"
#include "runtime/stop_signal.h"
#include "tools/commands.h"
#include "tools/live/hub_report.h"
#include "tools/live/top_view.h"
#include "tools/live/touched_names.h"

namespace hapton {
namespace {

struct TopOptions {
  std::string hub = "127.0.0.1";
  std::string key_file;
  bool once = false;
  bool json = false;
  double interval_s = 1.0;
};

// The text with escape sequences that overwrite the screen line by line from the upper left corner, without flicker.
std::string overwriting_text(const std::string& text) {
  std::string painted = "\x1b[H";
  for (const char c : text) painted += c == '\n' ? std::string("\x1b[K\n") : std::string(1, c);
  return painted + "\x1b[J";
}

Result<void> top(const TopOptions& options) {
  const StopSignal stop;
  const auto reader = HubReader::open(options.hub, options.key_file);
  if (!reader) return tl::unexpected(reader.error());
  const bool repaints = ::isatty(STDOUT_FILENO) == 1 && !options.once && !options.json;
  std::optional<TopSnapshot> before;
  TouchedNames names;
  do {
    const auto texts = (*reader)->read();
    if (!texts) return stop.stop_requested() ? Result<void>() : tl::unexpected(texts.error());
    auto now = read_top_snapshot(texts->json, texts->csv);
    if (!now) return tl::unexpected(now.error());
    const auto make = options.json ? make_top_json : make_top_view;
    const std::string view = make(options.hub, *now, before ? &*before : nullptr, names.describe(now->report));
    fmt::print("{}", repaints ? overwriting_text(view) : view + (options.once || options.json ? "" : "\n"));
    std::fflush(stdout);
    before = std::move(*now);
    for (double remaining_s = options.once ? 0.0 : options.interval_s; remaining_s > 0.0 && !stop.stop_requested(); remaining_s -= 0.1) {
      (*reader)->idle(std::min(remaining_s, 0.1));
    }
  } while (!options.once && !stop.stop_requested());
  return {};
}

int run(const TopOptions& options) {
  const auto ended = top(options);
  if (!ended) fmt::print(stderr, "hapton top: {}\n", ended.error().what);
  return ended ? 0 : 1;
}

}  // namespace

void add_top_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<TopOptions>();
  const CommandLine command = app.add_subcommand("top", "Watch a running system: nodes, rates, latencies, counters");
  command.add_option("--hub", options->hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->key_file, kKeyHelp);
  command.add_flag("--once", options->once, "Print once, with the statistics since the hub's start, and exit");
  command.add_flag("--json", options->json, "Print one line of JSON for each update, for programs (docs/formats.md)");
  command.add_option("--interval", options->interval_s, "Seconds between updates").between(0.2, 3600.0).shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
