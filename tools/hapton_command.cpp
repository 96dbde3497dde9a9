#include "tools/hapton_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/similar_word.h"
#include "runtime/config.h"
#include "tools/command_line.h"
#include "tools/commands.h"

namespace hapton {
namespace {

constexpr int kBadCommandLine = 2;      // exit code
constexpr std::size_t kNameWidth = 14;  // width of the column of command names, in characters; wider than any name

// The direct subcommands of a command, including old names, without the groups of flags, which CLI11 keeps in the same list.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

// The text "; did you mean 'x'?" if a command that --help lists is similar to the word, otherwise a list of these commands.
std::string hint_command(const std::string& word, const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands) {
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  return similar_word_hint(word, known);
}

// True if a word stands in the position of a command but names none; prints an error then, with a suggestion.
bool reject_unknown(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* parent = &app;
  std::string so_far = app.get_name();
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const std::string word = argv[i];
    const std::vector<const CLI::App*> commands = commands_of(*parent);
    if (commands.empty()) return false;
    const auto child = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* command) { return command->get_name() == word; });
    if (child == commands.end()) {
      fmt::print(stderr, "{}: unknown command '{}'{}\n", so_far, word, hint_command(word, commands));
      return true;
    }
    parent = *child;
    so_far += " " + word;
  }
  return false;
}

// Adds each command under the heading of its group. A command that --help does not list stays unlisted.
void add_commands(CLI::App& app, int& exit_code) {
  std::size_t grouped_count = 0;
  for (const ListedCommand& listed : kCommands) {
    listed.add(CommandLine(app), exit_code);
    const std::vector<CLI::App*> all = app.get_subcommands([](CLI::App*) { return true; });
    for (; grouped_count < all.size(); ++grouped_count) {
      if (!all[grouped_count]->get_group().empty()) all[grouped_count]->group(std::string(listed.group));
    }
  }
}

// The commands that were parsed before the error, for example "hapton latency run".
std::string words_so_far(const CLI::App& app) {
  std::string words = app.get_name();
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  for (const CLI::App* command = parsed.empty() ? nullptr : parsed.front(); command != nullptr;) {
    words += " " + command->get_name();
    const std::vector<CLI::App*> children = command->get_subcommands();
    command = children.empty() ? nullptr : children.front();
  }
  return words;
}

}  // namespace

int run_hapton_command(int argc, const char* const* argv) {
  int exit_code = 0;
  CLI::App app{"Touch a scene without a device, look into meshes and recordings, measure, compare and check.", "hapton"};
  app.set_version_flag("--version", "hapton " HAPTON_VERSION);
  app.require_subcommand(1);
  add_commands(app, exit_code);
  // A narrow column, because command names are short. It is set after the commands are added, so that their flags keep the wider one.
  const auto narrow = std::make_shared<CLI::Formatter>();
  narrow->column_width(kNameWidth);
  app.formatter(narrow);
  if (argc < 2) {
    fmt::print("{}", app.help());
    return kBadCommandLine;
  }
  if (reject_unknown(app, argc, argv)) {
    return kBadCommandLine;
  }
  require_exact_numbers(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string command = words_so_far(app);
    std::string what = error.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    // CLI11 says only that a "subcommand" is required, even if an unknown flag stands in its place.
    const std::vector<std::string> unknown = app.remaining(true);
    if (what == "A subcommand is required") {
      const bool is_flag = !unknown.empty() && unknown.front().starts_with('-');
      what = !is_flag ? "give a command" : fmt::format("'{}' is not a flag of {}; give a command first", unknown.front(), command);
    }
    if (what.starts_with(": ")) what.erase(0, 2);  // CLI11 prints an empty name for a hidden option, such as an old name
    fmt::print(stderr, "{}: {}{}; see {} --help\n", command, what, suggest_flag(app), command);
    return kBadCommandLine;
  }
  return exit_code;
}

}  // namespace hapton
