#include "scene/unit.h"

#include <charconv>
#include <cmath>

namespace hapton {

Result<Unit> parse_unit(std::string_view text) {
  for (const Unit unit : {Unit::m, Unit::cm, Unit::mm, Unit::in}) {
    if (text == name_of(unit)) return unit;
  }
  return fail("unknown unit '{}': give m, cm, mm or in", text);
}

Result<double> parse_length(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string_view rest = text.substr(static_cast<std::size_t>(end - text.data()));
  if (rest.starts_with(' ')) rest.remove_prefix(1);
  const auto unit = rest.empty() && end == text.data() + text.size() ? Result<Unit>(Unit::m) : parse_unit(rest);
  const double length = unit ? number * metres_per(*unit) : 0.0;
  if (error != std::errc() || !unit || !std::isfinite(length) || length < 0.0) {
    return fail("'{}' is not a length: give a number, 0 or more, and m, cm, mm or in, as 0.1mm", text);
  }
  return length;
}

double metres_per(Unit unit) {
  switch (unit) {
    case Unit::m:
      return 1.0;
    case Unit::cm:
      return 0.01;
    case Unit::mm:
      return 0.001;
    case Unit::in:
      return 0.0254;
  }
  return 1.0;
}

std::string_view name_of(Unit unit) {
  switch (unit) {
    case Unit::m:
      return "m";
    case Unit::cm:
      return "cm";
    case Unit::mm:
      return "mm";
    case Unit::in:
      return "in";
  }
  return "m";
}

}  // namespace hapton
