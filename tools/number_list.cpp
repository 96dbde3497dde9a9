#include "tools/number_list.h"

#include <charconv>
#include <system_error>

namespace hapton {

std::optional<std::vector<double>> read_number_list(std::string_view text) {
  std::vector<double> numbers;
  const char* next = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    const auto [stop, error] = std::from_chars(next, end, numbers.emplace_back());
    if (error != std::errc()) return std::nullopt;
    if (stop == end) return numbers;
    if (*stop != ',') return std::nullopt;
    next = stop + 1;
  }
}

}  // namespace hapton
