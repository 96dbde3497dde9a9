#include "core/sculpt/closest_surface_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

// Corners of the six tetrahedra around a diagonal of a cube (Kuhn 1960); bits 0, 1 and 2 of a corner's number are its x, y and z.
constexpr std::array<std::array<std::size_t, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};
// Steps of Newton's method onto the zero set. The triangles are within h^2 / r of the zero set, and each step squares the distance / h.
constexpr int kNewtonSteps = 3;

// Steps along the surface. In a pit of radius r, with p at the distance d from its centre, each step leaves the share 1 - d / r of the way.
constexpr int kSlides = 20;
// In spacings: how much farther from p a slide may lead. This is the roughness h^2 / r for a radius of curvature r of 10 grid spacings h.
// On more curved surfaces the slide may end too early.
constexpr double kRoughness = 0.1;
// In spacings: closer to zero than this, Newton's method has arrived. What is left is far below the roughness.
constexpr double kOnSurface = 1e-6;

struct FieldCell {
  std::array<Vec3, 8> corner;
  std::array<double, 8> value;
};

// A search for the surface point closest to p; holds the closest one found so far.
class SurfaceSearch {
 public:
  SurfaceSearch(const CarvedField& field, const Vec3& p) : field_(field), p_(p), place_((p - field.origin_m()) / field.spacing_m()) {}

  // Searches the cells that come within `reach` spacings of p along each axis. True: these were all cells of the grid.
  bool search_within(double reach) {
    std::array<int, 3> first = {}, last = {};
    bool is_all = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const double most = field_.nodes()[i] - 2.0;
      const auto axis = static_cast<Eigen::Index>(i);
      first[i] = static_cast<int>(std::clamp(std::floor(place_[axis] - reach), 0.0, most));
      last[i] = static_cast<int>(std::clamp(std::floor(place_[axis] + reach), 0.0, most));
      is_all = is_all && first[i] == 0 && last[i] == static_cast<int>(most);
    }
    for (int z = first[2]; z <= last[2]; ++z) {
      for (int y = first[1]; y <= last[1]; ++y) {
        for (int x = first[0]; x <= last[0]; ++x) search_cell(x, y, z);
      }
    }
    return is_all;
  }

  double distance_m() const { return std::sqrt(least_squared_); }
  const Vec3& closest() const { return closest_; }

 private:
  double squared_distance_to_cell(int x, int y, int z) const {
    const Vec3 low(x, y, z);
    const Vec3 offset = (low - place_).cwiseMax(place_ - low - Vec3::Ones()).cwiseMax(0.0);
    return field_.spacing_m() * field_.spacing_m() * offset.squaredNorm();
  }

  void search_cell(int x, int y, int z) {
    if (squared_distance_to_cell(x, y, z) >= least_squared_) return;
    FieldCell cell;
    bool is_inside = false, is_outside = false;
    for (int k = 0; k < 8; ++k) {
      const int dx = k & 1, dy = (k >> 1) & 1, dz = k >> 2;
      const auto i = static_cast<std::size_t>(k);
      cell.value[i] = field_.values()[field_.grid().index(x + dx, y + dy, z + dz)];
      (cell.value[i] < 0.0 ? is_inside : is_outside) = true;
    }
    if (!is_inside || !is_outside) return;
    for (int k = 0; k < 8; ++k)
      cell.corner[static_cast<std::size_t>(k)] = field_.grid().node(x + (k & 1), y + ((k >> 1) & 1), z + (k >> 2));
    for (const auto& corners : kTetrahedra) search_cell(cell, corners);
  }

  void search_cell(const FieldCell& cell, const std::array<std::size_t, 4>& corners) {
    std::array<std::size_t, 4> inside = {}, outside = {};
    std::size_t inside_count = 0, outside_count = 0;
    for (const std::size_t c : corners) (cell.value[c] < 0.0 ? inside[inside_count++] : outside[outside_count++]) = c;
    const auto cross = [&](std::size_t i, std::size_t o) {
      const std::size_t a = inside[i], b = outside[o];
      return Vec3(cell.corner[a] + cell.value[a] / (cell.value[a] - cell.value[b]) * (cell.corner[b] - cell.corner[a]));
    };
    if (inside_count == 1) consider(cross(0, 0), cross(0, 1), cross(0, 2));
    if (inside_count == 3) consider(cross(0, 0), cross(1, 0), cross(2, 0));
    if (inside_count == 2) {
      consider(cross(0, 0), cross(0, 1), cross(1, 1));
      consider(cross(0, 0), cross(1, 1), cross(1, 0));
    }
  }

  void consider(const Vec3& a, const Vec3& b, const Vec3& c) {
    const ClosestPoint found = closest_point(a, b, c, p_);
    if (found.distance * found.distance >= least_squared_) return;
    least_squared_ = found.distance * found.distance;
    closest_ = found.point;
  }

  const CarvedField& field_;
  Vec3 p_;
  Vec3 place_;  // position of p, in spacings from the first node
  double least_squared_ = std::numeric_limits<double>::infinity();
  Vec3 closest_ = Vec3::Zero();
};

Vec3 go_to_zero(const CarvedField& field, Vec3 p) {
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Vec3 gradient = field.gradient(p);
    const double squared = gradient.squaredNorm();
    const Vec3 next = squared > 0.0 ? Vec3(p - field.value(p) / squared * gradient) : p;
    // In a sharp crease the gradient is not that of any side of the crease, and a step may lead away from zero.
    if (!(std::abs(field.value(next)) < std::abs(field.value(p)))) break;
    p = next;
  }
  return p;
}

// Slides along the surface to where its smoothed normal points at p. The triangles, and the zero set itself, are rough by h^2 / r, so at
// the distance d the closest point of the rough surface may be up to sqrt(2 d h^2 / r) beside that of the smooth one. If steps grow, or are
// longer than a spacing, as at an edge, or lead away from p, the point is already where it should be.
Vec3 slide_below(const CarvedField& field, const Vec3& p, Vec3 q) {
  const double most = (p - q).norm() + kRoughness * field.spacing_m();
  double last = field.spacing_m();
  for (int i = 0; i < kSlides; ++i) {
    const Vec3 normal = field.gradient(q).normalized();
    const Vec3 slip = (p - q) - normal.dot(p - q) * normal;
    const Vec3 next = go_to_zero(field, q + slip);
    const bool is_on_it = std::abs(field.value(next)) <= kOnSurface * field.spacing_m();
    if (!(slip.norm() < last) || !is_on_it || !((next - p).norm() <= most)) break;
    last = slip.norm();
    q = next;
  }
  return q;
}

}  // namespace

std::optional<Vec3> find_closest_surface_point(const CarvedField& field, const Vec3& p) {
  SurfaceSearch search(field, p);
  double reach = 2.0;
  while (!search.search_within(reach) && !(search.distance_m() <= reach * field.spacing_m())) reach *= 2.0;
  if (!std::isfinite(search.distance_m())) return std::nullopt;
  return slide_below(field, p, go_to_zero(field, search.closest()));
}

}  // namespace hapton
