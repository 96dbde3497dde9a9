#pragma once

#include <fmt/core.h>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace hapton {

// An ordinary failure in one line: what went wrong, where, and how to fix it.
struct Error {
  std::string what;
};

// A value, or the reason why there is none. RT: set-up only, as an Error allocates its text.
template <class T>
using Result = tl::expected<T, Error>;

// Makes the error side of a Result from a format string.
template <class... Args>
tl::unexpected<Error> fail(fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error{fmt::format(format, std::forward<Args>(args)...)});
}

}  // namespace hapton
