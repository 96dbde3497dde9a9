// Any bytes as a STL file.
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(stl) { hapton::fuzz::require_sound(hapton::read_stl(hapton::fuzz::text_of(bytes))); }
