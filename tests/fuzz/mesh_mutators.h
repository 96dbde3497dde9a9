#pragma once

#include <span>

#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// A binary STL file that is as long as its count says; a GLB file that is as long as its header says and whose chunks fill it.
bool has_stl_count(std::span<const std::uint8_t> file);
bool has_glb_lengths(std::span<const std::uint8_t> file);

// A binary STL file with changed triangles and the count that belongs to them; other files are changed plainly.
Bytes mutate_stl(std::span<const std::uint8_t> file, Mutation& mutation);

// A GLB file with a change in one chunk and the lengths that belong to it, the first buffer's in the JSON included; other files are changed
// plainly.
Bytes mutate_glb(std::span<const std::uint8_t> file, Mutation& mutation);

}  // namespace hapton::fuzz
