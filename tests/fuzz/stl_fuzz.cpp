// Any bytes as an STL file.
#include "tests/fuzz/mesh_mutators.h"
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(stl) {
  if (hapton::fuzz::has_stl_count(bytes)) hapton::fuzz::note_passage();
  hapton::fuzz::require_sound(hapton::read_stl(hapton::fuzz::text_of(bytes)));
}

FUZZ_MUTATOR(stl, hapton::fuzz::mutate_stl);
