#include "core/geometry/point_in_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

// Fixed directions in which the three rays are offset, with digits of irrational constants: meshes are hardly ever aligned with them.
constexpr std::array<std::array<double, 3>, 3> kRayOffsets = {
    {{0.31, 0.7310585786, -0.5772156649}, {-0.27, -0.6180339887, -0.4142135624}, {0.11, 0.1415926536, 0.7182818285}}};

double doubled_area(double ay, double az, double by, double bz, double cy, double cz) {
  return (by - ay) * (cz - az) - (bz - az) * (cy - ay);
}

}  // namespace

PointInMesh::PointInMesh(const TriangleMesh& mesh, double jitter, std::size_t most_listings) : mesh_(mesh) {
  const MeshBounds bounds = compute_bounds(mesh);
  low_ = bounds.low;
  high_ = bounds.high;
  jitter_m_ = jitter * bounds.extent();
  cells_ = static_cast<int>(std::clamp(std::sqrt(static_cast<double>(mesh.triangles.size()) / 2.0), 1.0, 512.0));
  while (cells_ > 1 && count_listings() > most_listings * mesh_.triangles.size()) cells_ /= 2;
  const auto cells = static_cast<std::size_t>(cells_);
  auto visit = [&](auto&& act) {
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      const Cells covered = cells_of(i);
      for (std::size_t row = covered.first_row; row <= covered.last_row; ++row) {
        for (std::size_t column = covered.first_column; column <= covered.last_column; ++column) act(row * cells + column, i);
      }
    }
  };
  first_.assign(cells * cells + 1, 0);
  visit([&](std::size_t cell, std::uint32_t) { ++first_[cell + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  listed_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  visit([&](std::size_t cell, std::uint32_t triangle) { listed_[next[cell]++] = triangle; });
}

std::size_t PointInMesh::cell_of(double y, double z) const {
  auto place = [&](double value, double low, double high) {
    const double share = high > low ? (value - low) / (high - low) : 0.0;
    return static_cast<std::size_t>(std::clamp(share * cells_, 0.0, cells_ - 1.0));
  };
  return place(z, low_.z(), high_.z()) * static_cast<std::size_t>(cells_) + place(y, low_.y(), high_.y());
}

PointInMesh::Cells PointInMesh::cells_of(std::size_t triangle) const {
  const Vec3 &a = mesh_.corner(triangle, 0), &b = mesh_.corner(triangle, 1), &c = mesh_.corner(triangle, 2);
  const Vec3 least = a.cwiseMin(b).cwiseMin(c);
  const Vec3 most = a.cwiseMax(b).cwiseMax(c);
  const auto cells = static_cast<std::size_t>(cells_);
  const std::size_t from = cell_of(least.y(), least.z());
  const std::size_t to = cell_of(most.y(), most.z());
  return {from / cells, to / cells, from % cells, to % cells};
}

std::size_t PointInMesh::count_listings() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    const Cells covered = cells_of(i);
    count += (covered.last_row - covered.first_row + 1) * (covered.last_column - covered.first_column + 1);
  }
  return count;
}

bool PointInMesh::is_inside(const Vec3& p) const {
  int votes = 0;
  for (const auto& ray_offset : kRayOffsets) {
    const Vec3 q = p + jitter_m_ * Vec3(ray_offset[0], ray_offset[1], ray_offset[2]);
    if (!((q.array() >= low_.array()).all() && (q.array() <= high_.array()).all())) continue;  // also skips a point with a NaN coordinate
    votes += winding_along_x(q) != 0;
  }
  return votes >= 2;
}

// Signed number of crossings of the ray from p towards +x. May be wrong for a ray exactly through an edge: the other two rays outvote it.
int PointInMesh::winding_along_x(const Vec3& p) const {
  int winding = 0;
  const std::size_t cell = cell_of(p.y(), p.z());
  for (std::uint32_t at = first_[cell]; at < first_[cell + 1]; ++at) {
    const std::uint32_t triangle = listed_[at];
    const Vec3 &a = mesh_.corner(triangle, 0), &b = mesh_.corner(triangle, 1), &c = mesh_.corner(triangle, 2);
    if (a.x() < p.x() && b.x() < p.x() && c.x() < p.x()) continue;
    const double wa = doubled_area(b.y(), b.z(), c.y(), c.z(), p.y(), p.z());
    const double wb = doubled_area(c.y(), c.z(), a.y(), a.z(), p.y(), p.z());
    const double wc = doubled_area(a.y(), a.z(), b.y(), b.z(), p.y(), p.z());
    const bool positive = wa > 0.0 && wb > 0.0 && wc > 0.0;
    const bool negative = wa < 0.0 && wb < 0.0 && wc < 0.0;
    if (!positive && !negative) continue;
    const double x = (wa * (a.x() - p.x()) + wb * (b.x() - p.x()) + wc * (c.x() - p.x())) / (wa + wb + wc);
    if (x > 0.0) winding += positive ? 1 : -1;
  }
  return winding;
}

double PointInMesh::compute_distance(const Vec3& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    const Vec3 &a = mesh_.corner(i, 0), &b = mesh_.corner(i, 1), &c = mesh_.corner(i, 2);
    const Vec3 out = (a.cwiseMin(b).cwiseMin(c) - p).cwiseMax(p - a.cwiseMax(b).cwiseMax(c)).cwiseMax(0.0);
    if (out.squaredNorm() > nearest * nearest) continue;
    nearest = std::min(nearest, closest_point(a, b, c, p).distance);
  }
  return nearest;
}

}  // namespace hapton
