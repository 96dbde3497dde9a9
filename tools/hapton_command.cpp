#include "tools/hapton_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/near_miss.h"
#include "runtime/config.h"
#include "tools/command_line.h"
#include "tools/commands.h"

namespace hapton {
namespace {

constexpr int kBadCommandLine = 2;

// True when the first word is meant as a command but is none; says so, with what may have been meant.
bool refuse_unknown(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2 || argv[1][0] == '-') {
    return false;
  }
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    names.push_back(command->get_name());
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  if (std::find(known.begin(), known.end(), argv[1]) != known.end()) {
    return false;
  }
  fmt::print(stderr, "hapton: unknown command '{}'{}\n", argv[1], near_miss_hint(argv[1], known));
  return true;
}

// "hapton latency run": the commands that were understood before the trouble began.
std::string words_so_far(const CLI::App& app) {
  std::string words = app.get_name();
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  for (const CLI::App* command = parsed.empty() ? nullptr : parsed.front(); command != nullptr;) {
    words += " " + command->get_name();
    const std::vector<CLI::App*> below = command->get_subcommands();
    command = below.empty() ? nullptr : below.front();
  }
  return words;
}

}  // namespace

int run_hapton_command(int argc, const char* const* argv) {
  int exit_code = 0;
  CLI::App app{"Hapton: replay, measure and change a haptic system from the command line.", "hapton"};
  app.set_version_flag("--version", "hapton " HAPTON_VERSION);
  app.require_subcommand(1);
  const CommandLine commands(app);
  add_bench_command(commands, exit_code);
  add_doctor_command(commands, exit_code);
  add_echo_command(commands, exit_code);
  add_evaluate_command(commands, exit_code);
  add_figures_command(commands, exit_code);
  add_governor_command(commands, exit_code);
  add_info_command(commands, exit_code);
  add_keygen_command(commands, exit_code);
  add_latency_command(commands, exit_code);
  add_plot_command(commands, exit_code);
  add_relay_command(commands, exit_code);
  add_replay_command(commands, exit_code);
  add_session_command(commands, exit_code);
  add_set_command(commands, exit_code);
  add_soak_command(commands, exit_code);
  add_stress_command(commands, exit_code);
  add_summary_command(commands, exit_code);
  add_top_command(commands, exit_code);
  add_trajectory_command(commands, exit_code);
  if (argc < 2) {
    fmt::print("{}", app.help());
    return kBadCommandLine;
  }
  if (refuse_unknown(app, argc, argv)) {
    return kBadCommandLine;
  }
  require_finite_numbers(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string command = words_so_far(app);
    std::string what = error.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    fmt::print(stderr, "{}: {}{}; see {} --help\n", command, what, suggest_flag(app), command);
    return kBadCommandLine;
  }
  return exit_code;
}

}  // namespace hapton
