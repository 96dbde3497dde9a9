#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace hapton {

// The content of a text in a message (HapticsSetup::Text), up to its first NUL. RT: yes.
template <std::size_t N>
std::string_view text_of(const std::array<char, N>& text) noexcept {
  return {text.data(), static_cast<std::size_t>(std::find(text.begin(), text.end(), '\0') - text.begin())};
}

}  // namespace hapton
