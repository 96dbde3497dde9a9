#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// Reads which object of the scene a request is about, as a person or a program names it: its name, or "#N", its number from 0. Sets either
// `name` or `number`. RT: no. Error: one line that says what may be given.
Result<void> choose_object(std::string_view object, std::array<char, 256>& name, std::int32_t& number);

}  // namespace hapton
