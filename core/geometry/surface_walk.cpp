#include "core/geometry/surface_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hapton {

SurfaceWalk::SurfaceWalk(const TriangleMesh& mesh) : mesh_(mesh), neighbour_(mesh.triangles.size(), {kNone, kNone, kNone}) {
  struct Use {
    std::uint32_t low, high, triangle;
    int edge;
  };
  std::vector<Use> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!has_area(i)) continue;
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]);
      uses.push_back({low, high, i, k});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) { return std::pair(a.low, a.high) < std::pair(b.low, b.high); });
  for (std::size_t first = 0; first < uses.size();) {
    std::size_t last = first;
    while (last < uses.size() && uses[last].low == uses[first].low && uses[last].high == uses[first].high) ++last;
    if (last - first == 2) {
      neighbour_[uses[first].triangle][uses[first].edge] = uses[first + 1].triangle;
      neighbour_[uses[first + 1].triangle][uses[first + 1].edge] = uses[first].triangle;
    }
    first = last;
  }
}

bool SurfaceWalk::has_area(std::uint32_t triangle) const {
  const Vec3 twice = (mesh_.corner(triangle, 1) - mesh_.corner(triangle, 0)).cross(mesh_.corner(triangle, 2) - mesh_.corner(triangle, 0));
  return twice.squaredNorm() > 0.0;
}

Vec3 SurfaceWalk::face_normal(std::uint32_t triangle) const {
  return (mesh_.corner(triangle, 1) - mesh_.corner(triangle, 0)).cross(mesh_.corner(triangle, 2) - mesh_.corner(triangle, 0)).normalized();
}

Vec3 SurfaceWalk::normal() const { return side_ * face_normal(triangle_); }

void SurfaceWalk::start(std::uint32_t triangle, double heading_rad) {
  triangle_ = triangle;
  entry_ = -1;
  side_ = 1.0;
  point_ = (mesh_.corner(triangle, 0) + mesh_.corner(triangle, 1) + mesh_.corner(triangle, 2)) / 3.0;
  heading_ = (mesh_.corner(triangle, 1) - mesh_.corner(triangle, 0)).normalized();
  turn(heading_rad);
}

void SurfaceWalk::turn(double angle_rad) { heading_ = Eigen::AngleAxisd(angle_rad, normal()) * heading_; }

void SurfaceWalk::advance(double length) {
  for (int crossings = 0; crossings < 10000 && length > 0.0; ++crossings) {
    const Vec3 up = face_normal(triangle_);
    double nearest = std::numeric_limits<double>::infinity();
    int exit = -1;
    for (int k = 0; k < 3; ++k) {
      if (k == entry_) continue;
      const Vec3& corner = mesh_.corner(triangle_, k);
      const Vec3 inward = up.cross(mesh_.corner(triangle_, (k + 1) % 3) - corner).normalized();
      const double speed = -inward.dot(heading_);
      if (!(speed > 0.0)) continue;
      const double time = std::max(0.0, inward.dot(point_ - corner)) / speed;
      if (time < nearest) {
        nearest = time;
        exit = k;
      }
    }
    if (exit < 0 || nearest >= length) {
      point_ += length * heading_;
      if (nearest > length) entry_ = -1;
      return;
    }
    point_ += nearest * heading_;
    length -= nearest;
    cross_edge(exit);
  }
}

void SurfaceWalk::cross_edge(int edge) {
  const std::uint32_t a = mesh_.triangles[triangle_][edge];
  const std::uint32_t b = mesh_.triangles[triangle_][(edge + 1) % 3];
  const Vec3 along = (mesh_.vertices[b] - mesh_.vertices[a]).normalized();
  const std::uint32_t next = neighbour_[triangle_][edge];
  const Vec3 inward = face_normal(triangle_).cross(along);
  const double through = -heading_.dot(inward);  // > 0
  const double along_edge = heading_.dot(along);
  if (next == kNone) {
    heading_ = (along_edge * along + through * inward).normalized();
    entry_ = edge;
    return;
  }
  int entry = 0;
  while (!((mesh_.triangles[next][entry] == a && mesh_.triangles[next][(entry + 1) % 3] == b) ||
           (mesh_.triangles[next][entry] == b && mesh_.triangles[next][(entry + 1) % 3] == a))) {
    ++entry;
  }
  const bool is_flipped = mesh_.triangles[next][entry] == a;
  const Vec3 next_inward = face_normal(next).cross(is_flipped ? along : Vec3(-along));
  heading_ = (along_edge * along + through * next_inward).normalized();
  if (is_flipped) side_ = -side_;
  triangle_ = next;
  entry_ = entry;
}

}  // namespace hapton
