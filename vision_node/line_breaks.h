#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace hapton {

// The text with each line that does not fit in several: broken at three blanks, as between the entries of the HUD's lines, and an entry
// that does not fit itself at single ones. A word that does not fit stays whole. fits: whether a line does.
std::string break_lines(std::string_view text, const std::function<bool(std::string_view)>& fits);

}  // namespace hapton
