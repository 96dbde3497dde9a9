#include "scene/raw_mesh.h"

#include <utility>

namespace hapton {

void RawMesh::begin_part(std::string name) {
  end_parts();
  parts.push_back({.name = std::move(name), .first_triangle = mesh.triangles.size(), .triangle_count = 0});
}

void RawMesh::end_parts() {
  if (parts.empty()) return;
  parts.back().triangle_count = mesh.triangles.size() - parts.back().first_triangle;
  if (parts.back().triangle_count == 0) parts.pop_back();
}

}  // namespace hapton
