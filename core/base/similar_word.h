#pragma once

#include <span>
#include <string>
#include <string_view>

namespace hapton {

// The known word within a few letters of this one; empty if there is none. RT: no.
std::string_view find_similar_word(std::string_view word, std::span<const std::string_view> known);

// "; did you mean 'x'?" if a known word is within a few letters of the word, otherwise "; known are a, b, c".
std::string similar_word_hint(std::string_view word, std::span<const std::string_view> known);

}  // namespace hapton
