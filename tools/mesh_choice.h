#pragma once

#include <string>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "tools/command_line.h"

namespace hapton {

// The mesh on which a command (evaluate, trajectory) works, as given on its command line.
struct MeshChoice {
  std::string file;
  std::string unit;         // "m", "cm", "mm" or "in"; empty: that of the file, or m
  bool no_seal = false;     // leave cracks open
  std::string shape;        // name of a built-in shape, in place of a file
  double scale_to_m = 0.0;  // length of the longest side; 0: the mesh keeps its size
};

// Adds the options --mesh FILE [--unit U] [--no-seal] or --shape NAME, and --scale-to METRES.
void add_mesh_options(CommandLine command, MeshChoice& choice);

// Loads or generates the mesh. Error: an error of the loader; an unknown unit or shape, with the known ones; no extent to scale.
Result<TriangleMesh> make_mesh(const MeshChoice& choice);

// The name of the file without its extension, or of the shape: "bunny_69k", "bumpy".
std::string name_of(const MeshChoice& choice);

// Scales the mesh about the origin until its longest side is extent_m. Pre: the mesh has an extent.
TriangleMesh scaled_to(TriangleMesh mesh, double extent_m);

}  // namespace hapton
