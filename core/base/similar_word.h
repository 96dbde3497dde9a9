#pragma once

#include <span>
#include <string>
#include <string_view>

namespace hapton {

// The known word with the smallest edit distance to this one, at most a third of its length and at least 2 letters allowed, or one that it
// abbreviates; empty if there is none. RT: no.
std::string_view find_similar_word(std::string_view word, std::span<const std::string_view> known);

// "; did you mean 'x'?" if find_similar_word finds x, otherwise "; known are a, b, c". RT: no.
std::string similar_word_hint(std::string_view word, std::span<const std::string_view> known);

}  // namespace hapton
