#pragma once

#include <gmock/gmock.h>

#include <string>

namespace hapton {

// Matches a text that is not empty and has no line break, as an error's must be.
MATCHER(IsOneLine, "") { return !arg.empty() && arg.find('\n') == std::string::npos; }

}  // namespace hapton
