#pragma once

#include <string_view>

#include "core/base/result.h"

namespace hapton {

// The unit of the numbers in a mesh file.
enum class Unit { m, cm, mm, in };

inline constexpr const char* kUnitNames = "m, cm, mm, in";

// Reads m, cm, mm or in. Error: anything else. RT: set-up only.
Result<Unit> parse_unit(std::string_view text);

// A length in metres: a number and its unit ("0.1mm", "5 cm"); a number without a unit is in metres. RT: set-up only. Error: not a length,
// negative or not finite.
Result<double> parse_length(std::string_view text);

double metres_per(Unit unit);
std::string_view name_of(Unit unit);

}  // namespace hapton
