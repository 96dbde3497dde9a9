#pragma once

#include <fstream>
#include <sstream>
#include <string>

#include "core/geometry/triangle_mesh.h"

namespace hapton::made {

// The triangles of one of the project's own OBJ files (plain v and f lines), for tests of layers below scene/.
inline TriangleMesh obj_mesh(const std::string& name) {
  TriangleMesh mesh;
  std::ifstream file(std::string(HAPTON_SOURCE_DIR) + "/meshes/" + name);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vec3 v;
      words >> v.x() >> v.y() >> v.z();
      mesh.vertices.push_back(v);
    } else if (kind == "f") {
      std::vector<std::uint32_t> corners;
      for (std::string corner; words >> corner;) corners.push_back(static_cast<std::uint32_t>(std::stoul(corner) - 1));
      for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return mesh;
}

}  // namespace hapton::made
