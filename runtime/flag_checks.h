#pragma once

#include <CLI/CLI.hpp>

#include <cstdint>
#include <limits>
#include <string>

namespace hapton {

// Checks for CLI11 flags. A rejection is one short line; CLI11 puts the flag's name before it, and the node its own name: "--probe-radius:
// -1 is below zero; give metres, zero or more". CLI11's own checks would print an open bound with 309 digits. RT: set-up only.
//
// `what` is the unit or kind of the number ("metres"), for the line of the rejection.
CLI::Validator between(double least, double most);
CLI::Validator above_zero(const std::string& what = "a number");
CLI::Validator zero_or_more(const std::string& what = "a number");

// A whole number, in decimal or after 0x, from `least` to `most`. Without this check CLI11 reads -1 as the largest unsigned number, one
// with too many digits as the nearest that fits, and 010 as 8. Text that is not a finite number is left to the option's other checks.
CLI::Validator whole_number(std::int64_t least, std::uint64_t most);
template <class T>
CLI::Validator whole_number() {
  return whole_number(std::numeric_limits<T>::is_signed ? static_cast<std::int64_t>(std::numeric_limits<T>::min()) : 0,
                      static_cast<std::uint64_t>(std::numeric_limits<T>::max()));
}

// Folders and files that can be written to or made (runtime/writable_path.h).
CLI::Validator folder_to_write();
CLI::Validator file_to_write();

// Accepts what a parser accepts: Parse is callable with the text and returns a Result, whose error becomes the line of the rejection.
template <class Parse>
CLI::Validator accepts(Parse parse) {
  return CLI::Validator(
      [parse](std::string& text) {
        const auto read = parse(text);
        return read ? std::string() : read.error().what;
      },
      "");
}

}  // namespace hapton
