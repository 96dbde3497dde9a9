#include "core/collision/grid_division.h"

#include <charconv>

#include "core/collision/uniform_grid.h"

namespace hapton {
namespace {

// The count at the head of text, which is moved past it; 0 when there is none or too large a one.
int take_count(std::string_view& text) {
  int count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return error == std::errc() && count <= UniformGrid::kMaxDivision ? count : 0;
}

}  // namespace

Result<std::array<int, 3>> parse_grid_division(std::string_view text) {
  std::string_view rest = text;
  std::array<int, 3> division = {};
  division[0] = take_count(rest);
  division[1] = division[2] = division[0];
  if (!rest.empty()) {
    for (std::size_t axis = 1; axis < 3; ++axis) {
      const bool has_mark = rest.starts_with('x');
      rest.remove_prefix(has_mark ? 1 : 0);
      division[axis] = has_mark ? take_count(rest) : 0;
    }
  }
  if (!rest.empty() || division[0] < 1 || division[1] < 1 || division[2] < 1) {
    return fail("grid division '{}' is not understood; give cells along each axis, 1 to {}, as N or as NxNxN", text,
                UniformGrid::kMaxDivision);
  }
  return division;
}

}  // namespace hapton
