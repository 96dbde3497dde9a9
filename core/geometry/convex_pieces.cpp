#include "core/geometry/convex_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "core/geometry/far_points.h"
#include "core/geometry/point_in_mesh.h"

namespace hapton {
namespace {

using Box3 = Eigen::AlignedBox3d;

// No cut along a wall is nearer to the side of a cell than this share of the cell's size, so that each cut makes progress.
constexpr double kMinCutShare = 0.1;
// A wall counts as normal to an axis if it extends along the axis by at most this share of the cell.
constexpr double kMaxWallExtent = 0.01;

// A convex part of a triangle.
struct Face {
  Vec3 normal;
  std::vector<Vec3> corners;
};

// The part of a solid in a box-shaped cell.
struct Part {
  Box3 cell;
  std::vector<Face> faces;
  std::vector<Vec3> inner_corners;  // corners of the cell that are within the solid
  double concavity = 0.0;           // largest height of a point above the plane of a face; 0: not above the allowed one
  std::size_t worst_face = 0;       // the face with that height

  ConvexPiece points() const {
    ConvexPiece all = inner_corners;
    for (const Face& face : faces) all.insert(all.end(), face.corners.begin(), face.corners.end());
    return all;
  }
};

// Whether a face has a part on the side `sign` of the cut (see clip), or lies in the cut, with the solid on that side.
bool is_on_side(const Face& face, int axis, double at, double sign) {
  double low = 0.0;
  double high = 0.0;
  for (const Vec3& corner : face.corners) {
    low = std::min(low, sign * (corner[axis] - at));
    high = std::max(high, sign * (corner[axis] - at));
  }
  return low < 0.0 || (high == 0.0 && sign * face.normal[axis] > 0.0);
}

// The side of a face that is below `at` along an axis (sign 1), or above it (sign -1). Pre: is_on_side.
Face clip(const Face& face, int axis, double at, double sign) {
  Face kept{.normal = face.normal, .corners = {}};
  for (std::size_t i = 0; i < face.corners.size(); ++i) {
    const Vec3& from = face.corners[i];
    const Vec3& to = face.corners[(i + 1) % face.corners.size()];
    const double before = sign * (from[axis] - at);
    const double after = sign * (to[axis] - at);
    if (before <= 0.0) kept.corners.push_back(from);
    if ((before < 0.0 && after > 0.0) || (before > 0.0 && after < 0.0)) {
      Vec3 between = from + before / (before - after) * (to - from);
      between[axis] = at;
      kept.corners.push_back(between);
    }
  }
  return kept;
}

// A key for the plane of a face: the same for all faces that lie in the plane, except for rounding.
std::array<std::int64_t, 4> plane_of(const Face& face, const Vec3& origin, double extent) {
  constexpr double kSteps = 1.0 / FarPoints::kRelativeError;
  const double height = face.normal.dot(face.corners.front() - origin) / extent;
  return {std::llround(kSteps * face.normal.x()), std::llround(kSteps * face.normal.y()), std::llround(kSteps * face.normal.z()),
          std::llround(kSteps * height)};
}

// Finds the concavity of a part: of many faces in one plane, one stands for all. Returns how many points and boxes were looked at.
std::size_t find_concavity(Part& part, double max_concavity) {
  FarPoints points(part.points());
  if (!(points.extent() > 0.0)) return 0;
  std::set<std::array<std::int64_t, 4>> planes;
  double greatest_height = max_concavity;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const Face& face = part.faces[f];
    if (!planes.insert(plane_of(face, part.faces.front().corners.front(), points.extent())).second) continue;
    const double above = points.find_farthest(face.normal, face.corners.front(), greatest_height);
    if (!(above > greatest_height)) continue;
    greatest_height = part.concavity = above;
    part.worst_face = f;
  }
  return points.comparisons();
}

struct Cut {
  int axis = 0;
  double at = 0.0;
};

// Cuts along the wall of the notch if that is normal to an axis, as in a machined body; else across the middle of the longest side.
Cut choose_cut(const Part& part) {
  Cut cut;
  const Face& wall = part.faces[part.worst_face];
  wall.normal.cwiseAbs().maxCoeff(&cut.axis);
  double low = part.cell.max()[cut.axis];
  double high = part.cell.min()[cut.axis];
  for (const Vec3& corner : wall.corners) {
    low = std::min(low, corner[cut.axis]);
    high = std::max(high, corner[cut.axis]);
  }
  const double size = part.cell.sizes()[cut.axis];
  cut.at = low + 0.5 * (high - low);
  const double share = (cut.at - part.cell.min()[cut.axis]) / size;
  if (high - low <= kMaxWallExtent * size && share > kMinCutShare && share < 1.0 - kMinCutShare) return cut;
  part.cell.sizes().maxCoeff(&cut.axis);
  cut.at = part.cell.center()[cut.axis];
  return cut;
}

class Splitter {
 public:
  Splitter(const TriangleMesh& mesh, double max_concavity) : solid_(mesh), max_concavity_(max_concavity) {
    Part whole;
    for (const Triangle& t : mesh.triangles) {
      const std::vector<Vec3> corners = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
      const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      for (const Vec3& corner : corners) whole.cell.extend(corner);
      if (normal.squaredNorm() > 0.0) whole.faces.push_back({.normal = normal.stableNormalized(), .corners = corners});
    }
    finish(whole);
    parts_.push_back(std::move(whole));
  }

  std::vector<Part>& parts() { return parts_; }
  std::size_t comparisons() const { return comparisons_; }

  void split(std::size_t index) {
    const Part part = std::exchange(parts_[index], {});
    parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(index));
    const auto [axis, at] = choose_cut(part);
    for (const double sign : {1.0, -1.0}) {
      Part half{.cell = part.cell, .faces = {}, .inner_corners = {}};
      (sign > 0.0 ? half.cell.max() : half.cell.min())[axis] = at;
      for (const Face& face : part.faces) {
        if (is_on_side(face, axis, at, sign)) half.faces.push_back(clip(face, axis, at, sign));
      }
      if (half.faces.empty()) continue;  // the cell is outside the solid, or so deep inside that nothing touches it
      finish(half);
      parts_.push_back(std::move(half));
    }
  }

 private:
  void finish(Part& part) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 point = part.cell.corner(static_cast<Box3::CornerType>(corner));
      if (solid_.is_inside(point)) part.inner_corners.push_back(point);
    }
    comparisons_ += find_concavity(part, max_concavity_);
  }

  PointInMesh solid_;
  double max_concavity_;
  std::vector<Part> parts_;
  std::size_t comparisons_ = 0;
};

}  // namespace

std::vector<ConvexPiece> split_into_convex(const TriangleMesh& mesh, double max_concavity, std::size_t most_pieces,
                                           std::size_t* comparisons) {
  Splitter splitter(mesh, max_concavity);
  const auto less = [](const Part& a, const Part& b) { return a.concavity < b.concavity; };
  while (splitter.parts().size() < most_pieces) {
    const auto worst = std::ranges::max_element(splitter.parts(), less);
    if (worst == splitter.parts().end() || !(worst->concavity > max_concavity)) break;
    splitter.split(static_cast<std::size_t>(worst - splitter.parts().begin()));
  }
  if (comparisons != nullptr) *comparisons = splitter.comparisons();
  std::vector<ConvexPiece> pieces;
  for (const Part& part : splitter.parts()) pieces.push_back(part.points());
  return pieces;
}

}  // namespace hapton
