#pragma once

#include <string_view>

namespace hapton {

// Whether a marker may have this text: 1 to kMaxBytes of valid UTF-8 (no overlong form, surrogate or number above U+10FFFF) without control
// characters (U+0000 to U+001F, U+007F to U+009F) and line separators (U+2028, U+2029), so that it stays one cell of a table. RT: yes.
struct MarkerText {
  static constexpr std::size_t kMaxBytes = 160;
  static bool is_valid(std::string_view text) noexcept;
};

}  // namespace hapton
