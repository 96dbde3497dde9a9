#pragma once

#include <span>

#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// Whether a binary STL file is as long as its count says; whether a GLB file is as long as its header says and its chunks fill it.
bool has_stl_count(std::span<const std::uint8_t> file);
bool has_glb_lengths(std::span<const std::uint8_t> file);

// Changes triangles of a binary STL file and sets the count that fits them; other files get a plain change of bytes.
Bytes mutate_stl(std::span<const std::uint8_t> file, Mutation& mutation);

// Changes one chunk of a GLB file and sets the lengths that fit it, also that of the first buffer in the JSON; other files get a plain
// change of bytes.
Bytes mutate_glb(std::span<const std::uint8_t> file, Mutation& mutation);

}  // namespace hapton::fuzz
