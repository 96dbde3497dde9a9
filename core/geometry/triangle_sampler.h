#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Draws triangles with a probability proportional to their area. Units: any. RT: no. Threads: any for drawing.
class TriangleSampler {
 public:
  explicit TriangleSampler(const TriangleMesh& mesh) {
    sums_.reserve(mesh.triangles.size());
    double sum = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      sum += (mesh.corner(i, 1) - mesh.corner(i, 0)).cross(mesh.corner(i, 2) - mesh.corner(i, 0)).norm();
      sums_.push_back(sum);
    }
  }
  // Whether no triangle has an area, so that none can be drawn.
  bool empty() const { return sums_.empty() || !(sums_.back() > 0.0); }
  // The number of a triangle drawn at random. Pre: not empty().
  std::uint32_t operator()(std::mt19937_64& random) const {
    const double at = std::uniform_real_distribution<double>(0.0, sums_.back())(random);
    const auto found = std::upper_bound(sums_.begin(), sums_.end(), at);
    return static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(found - sums_.begin(), static_cast<std::ptrdiff_t>(sums_.size()) - 1));
  }

 private:
  std::vector<double> sums_;
};

}  // namespace hapton
