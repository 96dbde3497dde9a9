// Any bytes as a GLB file.
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(glb) { hapton::fuzz::require_sound(hapton::read_glb(hapton::fuzz::text_of(bytes), hapton::fuzz::kNoFolder)); }
