#pragma once

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <vector>

#include "core/collision/sweep_line.h"
#include "core/force/force_method.h"

namespace hapton::made {

// The same rule over all triangles of the scene, without a grid.
class BruteForceSweep {
 public:
  BruteForceSweep(const TouchScene& scene, double offset_m) : offset_m_(offset_m) {
    for (const TouchObject& object : scene.objects) {
      for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t) {
        if (const auto plane = compute_triangle_plane(object.mesh->corner(t, 0), object.mesh->corner(t, 1), object.mesh->corner(t, 2))) {
          planes_.push_back(*plane);
          stiffness_.push_back(object.material.stiffness_n_per_m);
        }
      }
    }
  }

  void reset(const Vec3& p) { last_ = p; }

  MethodOutput step(const Vec3& p) {
    std::vector<std::tuple<double, double, std::size_t, SweepCollision>> found;
    for (std::size_t t = 0; t < planes_.size(); ++t) {
      SweepCollision hit;
      if (compute_collision({last_, p}, planes_[t], hit) == SweepEnd::collision) {
        found.emplace_back(hit.t, -hit.depth, t, hit);
      }
    }
    collisions = found.size();
    MethodOutput output;
    output.p_SP = p;
    last_ = p;
    if (!found.empty()) {
      const auto& [t, depth, id, hit] = *std::min_element(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return std::tie(std::get<0>(a), std::get<1>(a), std::get<2>(a)) < std::tie(std::get<0>(b), std::get<1>(b), std::get<2>(b));
      });
      last_ = hit.point + offset_m_ * hit.normal;
      output.force_n = stiffness_[id] * hit.depth * hit.normal;
      output.p_SP = hit.point;
      output.contact = output.force_n != Vec3::Zero();
    }
    return output;
  }

  std::size_t collisions = 0;  // of the last step

 private:
  double offset_m_;
  std::vector<TrianglePlane> planes_;
  std::vector<double> stiffness_;
  Vec3 last_ = Vec3::Zero();
};

}  // namespace hapton::made
