#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): the library's name
class App;
class Option;
}  // namespace CLI

namespace hapton {

// One option or argument of a command. A handle: copies mean the same option. Pre: the program's CLI::App outlives it.
class CommandOption {
 public:
  explicit CommandOption(CLI::Option& option) : option_(&option) {}

  CommandOption required() const;
  // --help shows the value that the variable has when this is called.
  CommandOption shows_default() const;
  CommandOption between(int least, int most) const;
  CommandOption between(std::size_t least, std::size_t most) const;
  CommandOption between(double least, double most) const;
  // `what` is the unit or kind of the number ("metres"), for the line that rejects it.
  CommandOption positive(const std::string& what = "a number") const;
  CommandOption not_negative(const std::string& what = "a number") const;
  CommandOption one_of(const std::vector<std::string>& words) const;
  // names: "sphere, box, torus". The line that rejects another word names a similar one, or all. accepts_too: other words that are valid.
  CommandOption one_of_names(const std::string& names, std::function<bool(const std::string&)> accepts_too = {}) const;
  CommandOption existing_folder() const;
  // Rejected at the start if it can neither be written to nor created: its contents are written at the end.
  CommandOption folder_to_write() const;
  CommandOption file_to_write() const;
  // Can be given several times, one word each; all are kept.
  CommandOption again_for_more() const;
  CommandOption needs(CommandOption other) const;
  CommandOption excludes(CommandOption other) const;

 private:
  friend class CommandLine;
  CLI::Option* option_;
};

// One command of the `hapton` program: its options, and what it runs. It hides CLI11, whose headers cost a compiler seconds in every file
// that includes them. A handle like CommandOption.
class CommandLine {
 public:
  explicit CommandLine(CLI::App& app) : app_(&app) {}

  CommandLine add_subcommand(const std::string& name, const std::string& help) const;
  // The old name of a command: it still works, and --help does not list it.
  CommandLine add_old_subcommand(const std::string& old_name, const std::string& name) const;
  // A group of options that --help lists together.
  CommandLine add_group(const std::string& name, const std::string& help = {}) const;
  // T is std::string, std::filesystem::path, int, unsigned, std::size_t, double, an optional number or a vector of strings.
  // Pre: `into` outlives the parsing.
  template <class T>
  CommandOption add_option(const std::string& name, T& into, const std::string& help) const;
  CommandOption add_number(const std::string& name, std::function<void(double)> take, const std::string& help) const;
  CommandOption add_flag(const std::string& name, bool& into, const std::string& help) const;
  // The old name of an option: it still works and says so on stderr, and --help does not list it.
  void add_old_option(const std::string& old_name, CommandOption option) const;

  CommandLine require_options(std::size_t least, std::size_t most) const;
  CommandLine require_subcommands(std::size_t least, std::size_t most) const;
  // Pre: the command line is parsed.
  bool has_subcommand() const;
  // Sets the function that is called when the command line is parsed, if it names this command.
  void on_run(std::function<void()> run) const;

 private:
  CLI::App* app_;
};

}  // namespace hapton
