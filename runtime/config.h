#pragma once

#include <optional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): the library's name
class App;
}

namespace hapton {

// Adds --config FILE and --version to the program's flags and reads them all.
//
// The file is TOML; its keys are the long flags without dashes ("rate = 1000" for --rate 1000, "headless = true" for --headless); an array
// repeats the flag. A relative path means what it would mean on the command line. A flag given on the command line
// overrides the file's. A key that is no flag, a value of the wrong kind and a file that cannot be read are errors in one line that names
// file and line.
//
// Returns nothing when the program may go on, else the exit code to leave main with: 0 after --help and --version, 2 after an error
// (printed to stderr). RT: set-up only. Pre: the app's options are all added.
std::optional<int> parse_command_line(CLI::App& app, int argc, const char* const* argv);

// After a command line was refused: "; did you mean '--scene'?" of the first word in it that nobody knows; empty when none is like it.
// Pre: the app has parsed it.
std::string suggest_flag(const CLI::App& app);

// Makes the app and its commands refuse "nan" and "inf", which are numbers to CLI11 and lie in every range. parse_command_line does it by
// itself. Pre: the app's options are all added.
void require_finite_numbers(CLI::App& app);

}  // namespace hapton
