#pragma once

#include <span>
#include <string>
#include <string_view>

namespace hapton {

// The known word that is within a few letters of this one; empty when none is.
std::string_view find_near_miss(std::string_view word, std::span<const std::string_view> known);

// "; did you mean 'x'?" when one of the known words is within a few letters of the word, else "; known are a, b, c".
std::string near_miss_hint(std::string_view word, std::span<const std::string_view> known);

}  // namespace hapton
