#pragma once

#include <array>
#include <cstddef>

#include "core/math/types.h"

namespace hapton {

// The nodes of a regular grid, numbered with x fastest. Frame: that of the mesh (S), with parallel axes. Units: metres. RT: yes.
struct FieldGrid {
  Vec3 origin_m = Vec3::Zero();  // position of the node (0, 0, 0)
  double spacing_m = 0.0;
  std::array<int, 3> nodes = {0, 0, 0};  // along x, y, z

  std::size_t size() const { return std::size_t(nodes[0]) * std::size_t(nodes[1]) * std::size_t(nodes[2]); }
  std::size_t index(int x, int y, int z) const {
    return (std::size_t(z) * std::size_t(nodes[1]) + std::size_t(y)) * std::size_t(nodes[0]) + std::size_t(x);
  }
  Vec3 node(int x, int y, int z) const { return origin_m + spacing_m * Vec3(x, y, z); }
};

}  // namespace hapton
