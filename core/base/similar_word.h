#pragma once

#include <span>
#include <string>
#include <string_view>

namespace hapton {

// The known word with the smallest edit distance to `word`: at most a third of its letters, or 2 if that is more; a word of more than 64
// letters is not compared. A known word that begins with `word`, of 4 letters or more, is preferred. Empty: there is none. RT: no.
std::string_view find_similar_word(std::string_view word, std::span<const std::string_view> known);

// Returns "; did you mean 'x'?" if find_similar_word finds x, otherwise "; known are a, b, c". RT: no.
std::string similar_word_hint(std::string_view word, std::span<const std::string_view> known);

}  // namespace hapton
