#pragma once

#include <string>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "tools/command_line.h"

namespace hapton {

// Which mesh a judging command works on, as its command line says.
struct MeshChoice {
  std::string file;
  std::string unit;
  bool no_seal = false;
  std::string shape;
  double scale_to_m = 0.0;  // 0: as it is
};

// --mesh FILE [--unit U] [--no-seal] or --shape NAME, and --scale-to METRES.
void add_mesh_options(CommandLine command, MeshChoice& choice);

// Loads or makes it. Error: the loader's; an unknown shape, with the known ones.
Result<TriangleMesh> make_mesh(const MeshChoice& choice);

// "bunny_69k" or "bumpy".
std::string name_of(const MeshChoice& choice);

// The longest side becomes extent_m, the origin stays. Pre: the mesh has an extent.
TriangleMesh scaled_to(TriangleMesh mesh, double extent_m);

}  // namespace hapton
