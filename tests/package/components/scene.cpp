// Component scene alone: reads a mesh file in millimetres and reports what is wrong with it.
#include <cmath>
#include <cstdio>
#include <fstream>

#include "scene/mesh_report.h"

int main() {
  std::ofstream("part.obj") << "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const auto report = hapton::make_mesh_report("part.obj", hapton::Unit::mm);
  if (!report) return std::fprintf(stderr, "%s\n", report.error().what.c_str()), 1;
  std::printf("%s", hapton::to_text(*report).c_str());
  double longest_m = 0.0;
  for (const auto& vertex : report->file.mesh.vertices) longest_m = std::max(longest_m, vertex.norm());
  return std::abs(longest_m - 0.01) < 1e-12 && report->is_closed_for_touch() ? 0 : 1;
}
