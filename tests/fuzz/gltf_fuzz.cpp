// Any bytes as a glTF file.
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(gltf) {
  hapton::fuzz::require_sound(
      hapton::read_gltf(hapton::fuzz::text_of(bytes), hapton::fuzz::kNoFolder, hapton::fuzz::kMaxTriangles, hapton::AppearanceReading::on));
}
