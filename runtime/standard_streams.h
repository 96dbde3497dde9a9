#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// Opens those of stdin, stdout and stderr that are closed on /dev/null. Otherwise the next file or socket would take the number, and get
// what is printed. First line of every main. RT: set-up only.
void open_standard_streams();

// From now on a write to a pipe whose reader has gone fails, instead of ending the process: a node outlives whoever reads its log. RT:
// set-up only.
void outlive_readers();

// Prints text. What the stream does not take, as its reader has gone or its disk is full, is lost: fmt::print would throw, and end a node.
// RT: no.
void write_text(std::FILE* to, const std::string& text);

template <class... Args>
void print_text(std::FILE* to, fmt::format_string<Args...> format, Args&&... args) {
  write_text(to, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void print_text(fmt::format_string<Args...> format, Args&&... args) {
  write_text(stdout, fmt::format(format, std::forward<Args>(args)...));
}

// Whether all that was printed on stdout so far has arrived. Error: one line: it has not, as of a full disk. RT: no.
Result<void> flush_standard_output();

}  // namespace hapton
