// Any bytes as an OBJ file.
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(obj) { hapton::fuzz::require_sound(hapton::read_obj(hapton::fuzz::text_of(bytes), hapton::AppearanceReading::on)); }
