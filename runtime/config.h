#pragma once

#include <optional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): the library's name
class App;
}

namespace hapton {

// Adds --config FILE and --version to the program's flags and parses them all.
//
// The file is TOML; its keys are the long flags without dashes ("rate = 1000" for --rate 1000, "headless = true" for --headless); an array
// repeats the flag, and must not be empty. A relative path has the same meaning as on the command line. A flag given on the command line
// overrides that of the file. An error is one line that names the file, and the line in it unless the file cannot be read or the flag
// rejects the value.
//
// Returns nothing if the program may continue, otherwise the exit code for main: 0 after --help and --version, 2 after an error (printed to
// stderr). RT: set-up only. Pre: the app's options are all added.
std::optional<int> parse_command_line(CLI::App& app, int argc, const char* const* argv);

// For the message about a rejected command line: "; did you mean '--scene'?" for its first unknown word; empty if no flag is similar. Pre:
// the app has parsed the command line.
std::string suggest_flag(const CLI::App& app);

// Makes the app and its commands reject numbers that CLI11 accepts: "nan" and "inf", which pass every range check, and whole numbers that
// it misreads (flag_checks.h). parse_command_line does this itself. Pre: the app's options are all added.
void require_exact_numbers(CLI::App& app);

}  // namespace hapton
