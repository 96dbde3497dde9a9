#include "runtime/config.h"

#include <external/toml.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/similar_word.h"
#include "runtime/build_id.h"
#include "runtime/flag_checks.h"
#include "runtime/regular_file.h"
#include "runtime/standard_streams.h"
#include "runtime/toml_reader.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;  // far beyond any configuration
constexpr int kBadCommandLine = 2;

bool names_option(std::string_view argument, const CLI::Option& option) {
  const auto is_long = [&](const std::string& name) {
    const std::string flag = "--" + name;
    return argument == flag || argument.starts_with(flag + "=");
  };
  const auto is_short = [&](const std::string& name) { return argument.starts_with("-" + name); };
  return std::any_of(option.get_lnames().begin(), option.get_lnames().end(), is_long) ||
         (!argument.starts_with("--") && std::any_of(option.get_snames().begin(), option.get_snames().end(), is_short));
}

Result<std::string> scalar_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* flag = node.as_boolean()) return std::string(flag->get() ? "true" : "false");
  return fail("is not a text, number, true or false");
}

// The file's keys as command-line arguments, without those that `command_line` overrides.
class ConfigFile {
 public:
  ConfigFile(std::string path, CLI::App& app, const std::vector<std::string>& command_line)
      : path_(std::move(path)), app_(app), command_line_(command_line) {}

  Result<std::vector<std::string>> arguments();

  // " (from FILE)" if the message is about a flag that came from the file.
  std::string origin_of(std::string_view message) const;

 private:
  Result<toml::table> read() const;
  std::string suggest_key(std::string_view key) const;
  Result<void> add(std::string_view key, const toml::node& node);
  tl::unexpected<Error> fail_at(const toml::node& node, std::string_view what) const {
    return fail("{}:{}: {}", path_, node.source().begin.line, what);
  }

  std::string path_;
  CLI::App& app_;
  const std::vector<std::string>& command_line_;
  std::vector<std::string> arguments_;
  std::vector<std::string> flags_;
};

Result<toml::table> ConfigFile::read() const {
  if (path_.empty()) return fail("--config is empty; name a TOML file, or leave it out");
  const auto text = read_regular_file(path_, "--config wants a TOML file", kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  try {
    return toml::parse(*text, path_);
  } catch (const toml::parse_error& error) {
    return fail("{}:{}: {}", path_, error.source().begin.line, explain_toml_error(error.description()));
  }
}

Result<std::vector<std::string>> ConfigFile::arguments() {
  const Result<toml::table> table = read();
  if (!table) {
    return tl::unexpected(table.error());
  }
  for (const auto& [key, node] : *table) {
    if (const Result<void> added = add(key, node); !added) {
      return tl::unexpected(added.error());
    }
  }
  return arguments_;
}

std::string ConfigFile::suggest_key(std::string_view key) const {
  std::vector<std::string_view> known;
  for (const CLI::Option* option : static_cast<const CLI::App&>(app_).get_options()) {
    for (const std::string& name : option->get_lnames()) {
      if (name != key) known.emplace_back(name);
    }
  }
  const std::string_view best = find_similar_word(key, known);
  return best.empty() ? std::string() : fmt::format("; did you mean '{}'?", best);
}

Result<void> ConfigFile::add(std::string_view key, const toml::node& node) {
  const std::string flag = fmt::format("--{}", key);
  const CLI::Option* option = app_.get_option_no_throw(flag);
  if (option == nullptr || key == "config" || key == "help" || key == "version") {
    return fail_at(node, fmt::format("unknown key '{}'{}; keys are the program's flags without dashes, see --help", key, suggest_key(key)));
  }
  if (std::any_of(command_line_.begin(), command_line_.end(),
                  [&](const std::string& argument) { return names_option(argument, *option); })) {
    return {};
  }
  flags_.push_back(flag);
  if (const toml::array* array = node.as_array()) {
    // For an empty list, the flag would be given without a value, which switches a yes-or-no flag on.
    if (array->empty()) return fail_at(node, fmt::format("'{}' is an empty list; give it a value, or leave the key out", key));
    arguments_.push_back(flag);
    for (const toml::node& element : *array) {
      const Result<std::string> text = scalar_text(element);
      if (!text) {
        return fail_at(element, fmt::format("an element of '{}' {}", key, text.error().what));
      }
      arguments_.push_back(*text);
    }
    return {};
  }
  const Result<std::string> text = scalar_text(node);
  if (!text) {
    return fail_at(node, fmt::format("'{}' {}; there are no sections in this file", key, text.error().what));
  }
  if (text->empty()) {
    arguments_.insert(arguments_.end(), {flag, ""});
  } else {
    arguments_.push_back(flag + "=" + *text);
  }
  return {};
}

std::string ConfigFile::origin_of(std::string_view message) const {
  const bool is_ours =
      std::any_of(flags_.begin(), flags_.end(), [&](const std::string& flag) { return message.find(flag) != message.npos; });
  return is_ours ? fmt::format(" (from {})", path_) : "";
}

// Nullopt: there is no --config.
std::optional<std::string> find_config_path(const std::vector<std::string>& command_line) {
  constexpr std::string_view kFlag = "--config";
  for (std::size_t i = 0; i < command_line.size() && command_line[i] != "--"; ++i) {
    if (command_line[i] == kFlag && i + 1 < command_line.size()) {
      return command_line[i + 1];
    }
    if (command_line[i].starts_with("--config=")) {
      return command_line[i].substr(kFlag.size() + 1);
    }
  }
  return std::nullopt;
}

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') {
    text.pop_back();
  }
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// Adds the long flags and the names of the commands of `app`.
void add_words(const CLI::App& app, std::vector<std::string>& words) {
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
  // For CLI11, a group of options is a command without a name.
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name().empty() || command->get_display_name().starts_with("[Option Group")) {
      add_words(*command, words);
    } else {
      words.push_back(command->get_name());
    }
  }
}

const CLI::App& innermost_command(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) {
    if (!command->get_name().empty()) return innermost_command(*command);
  }
  return app;
}

std::string program_name(const CLI::App& app, int argc, const char* const* argv) {
  if (!app.get_name().empty()) {
    return app.get_name();
  }
  const std::string_view path = argc > 0 ? argv[0] : "hapton";
  return std::string(path.substr(path.rfind('/') + 1));
}

}  // namespace

std::string suggest_flag(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty()) return {};
  std::vector<std::string> words;
  add_words(innermost_command(app), words);
  const std::vector<std::string_view> known(words.begin(), words.end());
  const std::string_view best = find_similar_word(std::string_view(unknown.front()).substr(0, unknown.front().find('=')), known);
  return best.empty() ? std::string() : fmt::format("; did you mean '{}'?", best);
}

void require_exact_numbers(CLI::App& app) {
  const auto is_finite = [](const std::string& text) {
    const bool finite = std::isfinite(std::strtod(text.c_str(), nullptr));
    return finite ? std::string() : fmt::format("'{}' is not a finite number", text);
  };
  for (CLI::Option* option : app.get_options([](const CLI::Option*) { return true; })) {
    const std::string type = option->get_type_name();
    if (type.starts_with("FLOAT")) option->check(is_finite);
    if (type.starts_with("INT")) option->check(whole_number<std::int64_t>());
    if (type.starts_with("UINT")) option->check(whole_number<std::uint64_t>());
  }
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    require_exact_numbers(*command);
  }
}

std::optional<int> parse_command_line(CLI::App& app, int argc, const char* const* argv) {
  const std::string program = program_name(app, argc, argv);
  app.name(program);
  if (app.get_option_no_throw("--config") == nullptr) {
    // Read before CLI11 sees it (find_config_path); declared here for --help and for its checks.
    app.add_option_function<std::string>(
        "--config", [](const std::string&) {}, "TOML file with any of these flags (keys without dashes); the command line wins");
  }
  if (app.get_version_ptr() == nullptr) {
    app.set_version_flag("--version", program + " " + hapton_version());
  }
  std::vector<std::string> arguments;
  for (int i = 1; i < argc; ++i) {
    arguments.emplace_back(argv[i]);
  }
  const std::vector<std::string> command_line = arguments;
  const std::optional<std::string> path = find_config_path(command_line);
  ConfigFile file(path.value_or(""), app, command_line);
  if (path) {
    const Result<std::vector<std::string>> from_file = file.arguments();
    if (!from_file) {
      print_text(stderr, "{}: {}\n", program, one_line(from_file.error().what));
      return kBadCommandLine;
    }
    arguments.insert(std::find(arguments.begin(), arguments.end(), "--"), from_file->begin(), from_file->end());
  }
  require_exact_numbers(app);
  try {
    std::reverse(arguments.begin(), arguments.end());  // parse() takes the arguments in reverse order
    app.parse(arguments);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string message = one_line(error.what());
    print_text(stderr, "{}: {}{}{}; see {} --help\n", program, message, file.origin_of(message), suggest_flag(app), program);
    return kBadCommandLine;
  }
  return std::nullopt;
}

}  // namespace hapton
