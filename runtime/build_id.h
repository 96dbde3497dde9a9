#pragma once

#include <string>

namespace hapton {

// Hapton's version: "0.1.0". RT: set-up only.
std::string hapton_version();

// What this program was built from and how, in one line: "0.1.0, g++ 12.2.0, release AVX2 FMA". Builds of the same source, compiler and
// flags compute the same numbers to the last bit. RT: set-up only.
std::string build_id();

}  // namespace hapton
