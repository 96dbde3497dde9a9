#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/force/smooth/local_set.h"
#include "core/force/touch_scene.h"

namespace hapton {

// The value of MethodSettings::smooth_layer at which the force law f acts over all of RADIUS: Algorithm 1 as printed in the FDH paper,
// where every triangle with d in 0..RADIUS exerts a force outside the surface. `--method smooth --layer 1` selects it.
constexpr double kFdhPaperLayer = 1.0;

// Algorithm 1 of the FDH paper: the force of a set of triangles on a nearby probe, with smooth normals. In the paper's symbols: P the
// probe, T a triangle, B the closest point on an edge, n_i the normal interpolated there, R_i the plane of edge and n_i, d_i the distance
// from it, D the virtual contact point (VCP), f the force law. The paper's "fake triangles" are the degenerate triangles that fill the fan
// of normals at an edge or vertex. Where the paper leaves a choice: docs/decisions/0003-fdh-smooth.md. Frame S, metres, newtons. RT: all of
// it.

// The virtual contact point of one triangle.
// Not initialized: hundreds of them are on the fast task's stack.
struct SmoothVcp {
  Vec3 D;           // on the face's plane; on the edge or at the vertex of a degenerate triangle
  Vec3 away;        // unit, from D to P
  double distance;  // |DP|
  int sign;         // -1: a degenerate triangle at a concave edge; it subtracts what both adjacent faces contribute
  std::uint32_t object;
  std::uint32_t triangle;
  bool is_face;
};

// Computes the triangle's VCP for P. True if it has one: P is nearer to it than radius, on a side that can be touched, within the three
// planes R_i (a degenerate triangle: or beyond all three), and |DP| < radius.
bool find_vcp(const SetTriangle& triangle, const Vec3& P, double radius, SmoothVcp& vcp) noexcept;

// The smooth normal at a point X on (or above) a face: the three n_i weighted by 1 / d_i. Unit, on the face's own side.
Vec3 smooth_normal_at(const SetTriangle& face, const Vec3& X) noexcept;

// f: the force of a VCP at distance |DP|, newtons: a spring that begins at distance `layer` and is strongest on the surface.
inline double smooth_f(double stiffness_n_per_m, double layer, double distance) {
  return distance < layer ? stiffness_n_per_m * (layer - distance) : 0.0;
}

// The result of Algorithm 1.
struct SmoothForce {
  Vec3 force_n = Vec3::Zero();
  Vec3 D = Vec3::Zero();     // the nearest VCP that is not hidden and has sign 1
  Vec3 away = Vec3::Zero();  // unit, from D to P; zero if there is no such VCP
  std::uint32_t vcps = 0;
  std::uint32_t hidden = 0;         // VCPs removed as hidden, fig. 3 of the paper
  std::uint32_t over_capacity = 0;  // VCPs beyond the capacity: the farthest are dropped
};

// Collects VCPs and combines them.
class SmoothForceSum {
 public:
  static constexpr std::size_t kCapacity = 256;  // as in LocalSet; it is on the stack of the fast task

  SmoothForceSum(const Vec3& P, double radius) : P_(P), radius_(radius) {}

  void add(const SetTriangle& triangle) noexcept;

  // Drops the VCPs hidden by another face that has a VCP, and sums the rest: force / |force| * maxforce. materials: one per object.
  SmoothForce combine(double layer, std::span<const Material> materials) noexcept;

 private:
  struct CollectedVcp {
    SmoothVcp vcp;
    std::array<Vec3, 3> corner;
  };
  bool is_hidden(std::size_t i) const noexcept;

  Vec3 P_;
  double radius_;
  std::size_t count_ = 0;
  std::uint32_t over_capacity_ = 0;
  std::array<CollectedVcp, kCapacity> collected_;  // the first count_ are valid
};

// A straight line and its intersection with triangles. Vertices, edges and interiors all count, and no line passes between triangles that
// share vertices: each edge's test depends on its two vertices alone, and rounding can make it zero but never change its sign (Woop,
// Benthin & Wald 2013).
class StraightLine {
 public:
  StraightLine(const Vec3& from, const Vec3& to) noexcept;

  // Sets `at` to the position along the line: 0 at `from`, 1 at `to`, unbounded. False: there is no intersection, the line is in the
  // triangle's plane, or `from` equals `to`.
  bool meets(const std::array<Vec3, 3>& corner, double& at) const noexcept {
    if (!(extent_z_ != 0.0)) return false;
    std::array<double, 3> px;
    std::array<double, 3> py;
    std::array<double, 3> pz;
    // Sheared so that the line becomes the z axis, in the same way for every triangle.
    for (int k = 0; k < 3; ++k) {
      pz[k] = corner[k][z_] - from_[z_];
      px[k] = (corner[k][x_] - from_[x_]) - shear_x_ * pz[k];
      py[k] = (corner[k][y_] - from_[y_]) - shear_y_ * pz[k];
    }
    const double u = px[2] * py[1] - py[2] * px[1];
    const double v = px[0] * py[2] - py[0] * px[2];
    const double w = px[1] * py[0] - py[1] * px[0];
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return false;
    const double sum = u + v + w;
    if (sum == 0.0) return false;
    at = ((u * pz[0] + v * pz[1] + w * pz[2]) / sum) / extent_z_;
    return true;
  }

 private:
  Vec3 from_;
  int x_ = 1;
  int y_ = 2;
  int z_ = 0;  // the line's longest axis
  double extent_z_ = 0.0;
  double shear_x_ = 0.0;
  double shear_y_ = 0.0;
};

}  // namespace hapton
