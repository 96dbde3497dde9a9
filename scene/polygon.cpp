#include "scene/polygon.h"

#include <algorithm>

namespace hapton {
namespace {

using Vec2 = Eigen::Vector2d;

// Newell's normal: twice the area vector of a polygon of any shape. Computed relative to the first corner, to avoid cancellation.
Vec3 area_normal(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices) {
  const Vec3& origin = vertices[corners[0]];
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    normal += (vertices[corners[i]] - origin).cross(vertices[corners[i + 1]] - origin);
  }
  return normal;
}

double turn(const Vec2& a, const Vec2& b, const Vec2& c) { return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()); }

// Projects the polygon along the largest axis of its normal. The result is counter-clockwise.
std::vector<Vec2> flatten(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, const Vec3& normal) {
  int drop = 0;
  normal.cwiseAbs().maxCoeff(&drop);
  int u = (drop + 1) % 3;
  int v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  std::vector<Vec2> flat;
  for (const std::uint32_t corner : corners) flat.emplace_back(vertices[corner][u], vertices[corner][v]);
  return flat;
}

bool is_convex(const std::vector<Vec2>& flat) {
  const std::size_t n = flat.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) < 0) return false;
  }
  return true;
}

bool add_fan(std::span<const std::uint32_t> corners, std::vector<Triangle>& into) {
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) into.push_back({corners[0], corners[i], corners[i + 1]});
  return true;
}

// Cuts the ears of a polygon, which flatten has projected. For each corner it stores up to which number the others are known to be outside
// the corner's triangle. This stays true until that triangle changes, whatever is cut elsewhere. So all tests together are at most four
// times the square of the number of corners.
class EarCutter {
 public:
  explicit EarCutter(const std::vector<Vec2>& flat)
      : flat_(flat), previous_(flat.size()), next_(flat.size()), known_outside_(flat.size(), 0), is_cut_(flat.size(), false) {
    for (std::size_t i = 0; i < flat.size(); ++i) {
      next_[i] = (i + 1) % flat.size();
      previous_[next_[i]] = i;
    }
  }

  // False, with some of the triangles appended, when no ear is left to cut.
  bool cut_all(std::span<const std::uint32_t> corners, std::vector<Triangle>& into) {
    std::size_t remaining = corners.size();
    std::size_t misses = 0;
    for (std::size_t at = 0; remaining > 3; at = next_[at]) {
      if (!is_ear(at)) {
        if (++misses == remaining) return false;
        continue;
      }
      into.push_back({corners[previous_[at]], corners[at], corners[next_[at]]});
      cut(at);
      --remaining;
      misses = 0;
    }
    const auto first = static_cast<std::size_t>(std::find(is_cut_.begin(), is_cut_.end(), false) - is_cut_.begin());
    into.push_back({corners[first], corners[next_[first]], corners[next_[next_[first]]]});
    return true;
  }

  std::size_t work() const { return work_; }

 private:
  // An ear is a corner that turns left and has no other corner in or on its triangle.
  bool is_ear(std::size_t corner) {
    const Vec2& a = flat_[previous_[corner]];
    const Vec2& b = flat_[corner];
    const Vec2& c = flat_[next_[corner]];
    if (!(turn(a, b, c) > 0)) return false;
    for (std::size_t& other = known_outside_[corner]; other < flat_.size(); ++other) {
      if (is_cut_[other]) continue;
      ++work_;
      const Vec2& p = flat_[other];
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  void cut(std::size_t corner) {
    is_cut_[corner] = true;
    next_[previous_[corner]] = next_[corner];
    previous_[next_[corner]] = previous_[corner];
    known_outside_[previous_[corner]] = known_outside_[next_[corner]] = 0;
  }

  const std::vector<Vec2>& flat_;
  std::vector<std::size_t> previous_, next_;  // neighbours in the ring of the corners that are not cut
  std::vector<std::size_t> known_outside_;    // of each corner: the others below this number are outside its triangle, or cut
  std::vector<bool> is_cut_;
  std::size_t work_ = 0;
};

}  // namespace

bool triangulate_polygon(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, std::vector<Triangle>& into,
                         std::size_t* work) {
  if (corners.size() == 3) return add_fan(corners, into);
  const std::vector<Vec2> flat = flatten(corners, vertices, area_normal(corners, vertices));
  if (is_convex(flat)) return add_fan(corners, into);
  if (corners.size() > kMaxPolygonCorners) return false;
  const std::size_t before = into.size();
  EarCutter cutter(flat);
  const bool is_covered = cutter.cut_all(corners, into);
  if (work != nullptr) *work += cutter.work();
  if (is_covered) return true;
  into.resize(before);
  return add_fan(corners, into);
}

}  // namespace hapton
