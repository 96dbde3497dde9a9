#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// If stdin, stdout or stderr is closed, opens /dev/null in its place. Otherwise the next file or socket would get its number, and with it
// what is printed. Called at the beginning of every main. RT: set-up only.
void open_standard_streams();

// From now on a write to a pipe whose reader has gone fails, instead of ending the process: a node outlives whoever reads its log. RT:
// set-up only.
void outlive_readers();

// Prints text. What the stream does not take, because its reader has gone or its disk is full, is lost: fmt::print would throw, and end a
// node. RT: no.
void write_text(std::FILE* to, const std::string& text);

template <class... Args>
void print_text(std::FILE* to, fmt::format_string<Args...> format, Args&&... args) {
  write_text(to, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void print_text(fmt::format_string<Args...> format, Args&&... args) {
  write_text(stdout, fmt::format(format, std::forward<Args>(args)...));
}

// Writes out all that was printed on stdout. Error: one line: part of it was not written, for example because the disk is full. RT: no.
Result<void> flush_standard_output();

}  // namespace hapton
