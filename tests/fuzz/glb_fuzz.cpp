// Any bytes as a GLB file.
#include "tests/fuzz/mesh_mutators.h"
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(glb) {
  if (hapton::fuzz::has_glb_lengths(bytes)) hapton::fuzz::note_passage();
  hapton::fuzz::require_sound(
      hapton::read_glb(hapton::fuzz::text_of(bytes), hapton::fuzz::kNoFolder, hapton::fuzz::kMaxTriangles, hapton::AppearanceReading::on));
}

FUZZ_MUTATOR(glb, hapton::fuzz::mutate_glb);
