#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace hapton {

// Breaks each line that is too wide at triple spaces (between HUD entries), and what is still too wide at single spaces. A word that is
// too wide stays whole. fits: whether a line is narrow enough.
std::string break_lines(std::string_view text, const std::function<bool(std::string_view)>& fits);

}  // namespace hapton
