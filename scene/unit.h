#pragma once

#include <string_view>

#include "core/base/result.h"

namespace hapton {

// The length a mesh file's numbers are in.
enum class Unit { m, cm, mm, in };

// m, cm, mm or in; anything else is an error that says so. RT: set-up only.
Result<Unit> parse_unit(std::string_view text);

// A length in metres: a number with its unit behind it ("0.1mm", "5 cm"); a number alone is in metres. RT: set-up only.
// Error: not a length, negative or not finite.
Result<double> parse_length(std::string_view text);

double metres_per(Unit unit);
std::string_view name_of(Unit unit);

}  // namespace hapton
