// Any bytes as a PLY file.
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(ply) {
  hapton::fuzz::require_sound(hapton::read_ply(hapton::fuzz::text_of(bytes), hapton::fuzz::kNoFolder, hapton::AppearanceReading::on));
}
