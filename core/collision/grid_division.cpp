#include "core/collision/grid_division.h"

#include <charconv>

#include "core/collision/uniform_grid.h"

namespace hapton {
namespace {

// Parses the count at the start of text and removes it; 0 if there is none or it is too large.
int parse_count(std::string_view& text) {
  int count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return error == std::errc() && count <= UniformGrid::kMaxDivision ? count : 0;
}

}  // namespace

Result<std::array<int, 3>> parse_grid_division(std::string_view text) {
  std::string_view remaining = text;
  std::array<int, 3> division = {};
  division[0] = parse_count(remaining);
  division[1] = division[2] = division[0];
  if (!remaining.empty()) {
    for (std::size_t axis = 1; axis < 3; ++axis) {
      const bool has_mark = remaining.starts_with('x');
      remaining.remove_prefix(has_mark ? 1 : 0);
      division[axis] = has_mark ? parse_count(remaining) : 0;
    }
  }
  if (!remaining.empty() || division[0] < 1 || division[1] < 1 || division[2] < 1) {
    return fail("grid division '{}' is not understood; give cells along each axis, 1 to {}, as N or as NxNxN", text,
                UniformGrid::kMaxDivision);
  }
  return division;
}

}  // namespace hapton
