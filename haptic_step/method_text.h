#pragma once

#include <string>
#include <string_view>

#include "core/force/force_method.h"

namespace hapton {

// A method and its settings as words that go into a recording: "name=proxy probe_radius_m=0.001"; what is as by default is left out.
// Numbers come back to the last bit. RT: set-up only.
std::string to_text(const MethodSettings& settings);

// Error: a word that to_text does not write, a value out of its form.
Result<MethodSettings> parse_method_text(std::string_view text);

}  // namespace hapton
