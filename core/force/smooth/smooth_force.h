#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/force/smooth/local_set.h"

namespace hapton {

// The share of RADIUS (MethodSettings::smooth_layer) at which f fills all of it: Algorithm 1 as the paper prints it, where every triangle
// with d in 0..RADIUS exerts a force outside the surface. `--method smooth --layer 1` is that preset.
constexpr double kFdhPaperLayer = 1.0;

// Algorithm 1 of fdh-rendering.txt: the force that a set of triangles exerts on a probe near it, with smooth normals. In the paper's
// symbols: P the probe, T a triangle, B the nearest point on an edge, n_i the normal interpolated there, R_i the plane of edge and n_i, d_i
// the distance from it, D the virtual contact point (VCP), f the force law. Decisions where the paper leaves a choice:
// docs/decisions/0003-fdh-smooth.md. Frame S, metres, newtons. RT: all of it.

// Where a triangle pushes from.
// Not initialized: hundreds of them live on the fast task's stack.
struct SmoothVcp {
  Vec3 D;           // on the triangle's plane (face), on its edge or its point (fake triangles)
  Vec3 away;        // unit, from D to P
  double distance;  // |DP|
  int sign;         // -1: a fake triangle turned over at a concave edge; it takes away what the two faces count twice
  std::uint32_t object;
  std::uint32_t triangle;
  double stiffness_n_per_m;
  bool is_face;
};

// The triangle's VCP for P, if P lies over it: on a side that can be touched, nearer than radius, within the three planes R_i, and |DP| <
// radius.
bool find_vcp(const SetTriangle& triangle, const Vec3& P, double radius, SmoothVcp& vcp) noexcept;

// The smooth normal at a point X on (or over) a face: the three n_i weighted by 1 / d_i. Unit, on the face's own side.
Vec3 smooth_normal_at(const SetTriangle& face, const Vec3& X) noexcept;

// f: what a VCP at distance |DP| exerts, newtons: a spring that begins at `layer` and is strongest on the surface itself.
inline double smooth_f(double stiffness_n_per_m, double layer, double distance) {
  return distance < layer ? stiffness_n_per_m * (layer - distance) : 0.0;
}

// What Algorithm 1 gives.
struct SmoothForce {
  Vec3 force_n = Vec3::Zero();
  Vec3 D = Vec3::Zero();     // the VCP that pushes most
  Vec3 away = Vec3::Zero();  // unit, from it to P; zero when no triangle has a VCP
  std::uint32_t vcps = 0;
  std::uint32_t hidden = 0;       // removed, fig. 3
  std::uint32_t crowded_out = 0;  // beyond capacity: the farthest
};

// Collects VCPs and combines them.
class SmoothForceSum {
 public:
  static constexpr std::size_t kCapacity = 256;

  SmoothForceSum(const Vec3& P, double radius) : P_(P), radius_(radius) {}

  void add(const SetTriangle& triangle) noexcept;

  // Removes the VCPs hidden under another triangle with a VCP and adds up the rest: force / |force| * maxforce.
  SmoothForce combine(double layer) noexcept;

 private:
  struct Kept {
    SmoothVcp vcp;
    std::array<Vec3, 3> corner;
  };
  bool is_hidden(std::size_t i) const noexcept;

  Vec3 P_;
  double radius_;
  std::size_t count_ = 0;
  std::uint32_t crowded_out_ = 0;
  std::array<Kept, kCapacity> kept_;  // the first count_ are meant
};

// A straight line, and where it meets triangles. Corners, edges and insides count, and for triangles that share corners, no line slips
// through between them: each edge's test depends on its two corners alone, and rounding can only make it zero, never turn its sign
// (Woop, Benthin & Wald 2013).
class StraightLine {
 public:
  StraightLine(const Vec3& from, const Vec3& to) noexcept;

  // The position along the line, from = 0, to = 1, unbounded. false: it misses, runs in the plane of the triangle, or is no line.
  bool meets(const std::array<Vec3, 3>& corner, double& at) const noexcept {
    if (!(along_ != 0.0)) return false;
    std::array<double, 3> px;
    std::array<double, 3> py;
    std::array<double, 3> pz;
    // Sheared so that the line is the z axis; the same for every triangle.
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
    at = ((u * pz[0] + v * pz[1] + w * pz[2]) / sum) / along_;
    return true;
  }

 private:
  Vec3 from_;
  int x_ = 1;
  int y_ = 2;
  int z_ = 0;  // the line's longest axis
  double along_ = 0.0;
  double shear_x_ = 0.0;
  double shear_y_ = 0.0;
};

}  // namespace hapton
