#pragma once

#include "core/math/types.h"

namespace hapton {

// Where a surface that deforms is touched: a point of one of its triangles. Frame: that in which its mesh is at rest. Units: m.
struct SurfacePlace {
  Vec3 p_rest = Vec3::Zero();        // the same point of the mesh at rest
  Vec3 moved = Vec3::Zero();         // motion of the point since the step before
  Mat3 gradient = Mat3::Identity();  // takes the gradient along the mesh at rest of a number on it to its gradient now
};

// The SurfacePlace::gradient G of a triangle that has deformed from `rest` to `now`, with corners as columns in the same order: the
// transpose of G takes the edges and the unit normal of `now` to those of `rest`. Identity where the triangle has no area now. RT: yes.
inline Mat3 gradient_of_deformed(const Mat3& rest, const Mat3& now) noexcept {
  const auto basis = [](const Mat3& corners) {
    Mat3 edges;
    edges.col(0) = corners.col(1) - corners.col(0);
    edges.col(1) = corners.col(2) - corners.col(0);
    edges.col(2) = edges.col(0).cross(edges.col(1)).normalized();
    return edges;
  };
  // g_now . e_now = g_rest . e_rest for both edges and the unit normal.
  const Mat3 inverse = basis(now).transpose().inverse();
  const Mat3 gradient = inverse * basis(rest).transpose();
  return gradient.allFinite() ? gradient : Mat3(Mat3::Identity());
}

}  // namespace hapton
