#include "core/base/similar_word.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace hapton {
namespace {

// The Levenshtein distance, one row at a time.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

}  // namespace

std::string_view find_similar_word(std::string_view word, std::span<const std::string_view> known) {
  std::string_view best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view candidate : known) {
    // A shortened word, such as stiffness for stiffness_n_per_m, counts as near.
    const bool is_abbreviation = word.size() >= 4 && candidate.starts_with(word);
    const std::size_t distance = is_abbreviation ? 0 : word.size() > 64 ? word.size() : edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string similar_word_hint(std::string_view word, std::span<const std::string_view> known) {
  const std::string_view best = find_similar_word(word, known);
  if (!best.empty()) return fmt::format("; did you mean '{}'?", best);
  std::string all;
  for (const std::string_view candidate : known) all += fmt::format("{}{}", all.empty() ? "" : ", ", candidate);
  return fmt::format("; known are {}", all);
}

}  // namespace hapton
