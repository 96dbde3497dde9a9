#include "scene/unit.h"

namespace hapton {

Result<Unit> parse_unit(std::string_view text) {
  for (const Unit unit : {Unit::m, Unit::cm, Unit::mm, Unit::in}) {
    if (text == name_of(unit)) return unit;
  }
  return fail("unknown unit '{}': say m, cm, mm or in", text);
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
