#pragma once

#include <fmt/core.h>

#include <string_view>
#include <utility>

namespace hapton {

enum class LogLevel { debug, info, warning, error };

// Starts the log: lines for people on stderr, all in one style: "12:34:56.789 io_node  warning  text". Colour on a terminal only.
// RT: no, never in a loop that must keep time. Threads: any, after start_log.
void start_log(std::string_view program, LogLevel lowest = LogLevel::info);

void log_line(LogLevel level, std::string_view text);

template <class... Args>
void log_debug(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::debug, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::info, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::warning, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void log_error(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::error, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace hapton
