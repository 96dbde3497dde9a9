#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/collision/fdh_directions.h"
#include "core/geometry/mesh_shapes.h"
#include "tools/figures/drawing.h"

namespace hapton::figures {
namespace {

// --- Fixed Direction Hulls against boxes -----------------------------------------------------------------------------------------

Outline clipped(const Outline& polygon, const Eigen::Vector2d& normal, double limit) {  // keeps the part with normal . p <= limit
  Outline kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& p = polygon[i];
    const Eigen::Vector2d& q = polygon[(i + 1) % polygon.size()];
    const double from = normal.dot(p) - limit;
    const double to = normal.dot(q) - limit;
    if (from <= 0.0) kept.push_back(p);
    if ((from < 0.0) != (to < 0.0) && from != to) kept.push_back(p + from / (from - to) * (q - p));
  }
  return kept;
}

// The cross-section of a hull in the plane z = 0.
template <int K>
Outline slice_of(const FdhHull<K>& hull) {
  Outline polygon = {{hull.low[0], hull.low[1]}, {hull.high[0], hull.low[1]}, {hull.high[0], hull.high[1]}, {hull.low[0], hull.high[1]}};
  for (int i = 3; i < K / 2; ++i) {  // directions 0 to 2 are x, y and z
    const auto& axis = FdhDirections<K>::kAxis[i];
    const Eigen::Vector2d normal(axis[0], axis[1]);
    if (!normal.isZero(0.0)) polygon = clipped(clipped(polygon, normal, hull.high[i]), -normal, -hull.low[i]);
  }
  return polygon;
}

double area_of(const Outline& p) {
  double doubled_area = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const auto& q = p[(i + 1) % p.size()];
    doubled_area += p[i].x() * q.y() - p[i].y() * q.x();
  }
  return 0.5 * doubled_area;
}

struct Hulls {
  FdhHull<6> box;
  FdhHull<14> hull;
};

}  // namespace

Result<Figure> draw_hulls() {
  const TriangleMesh mesh = make_torus(0.03, 0.009, 96, 40);
  constexpr int kParts = 12;  // pieces of the torus that are drawn
  std::array<Hulls, kParts> parts;
  Points cut;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
    // The pieces resemble the nodes at one level of a tree: each is a twelfth of the ring's outer wall, near the plane z = 0.
    if (middle.head<2>().norm() > 0.03 && std::fabs(middle.z()) < 0.004) {
      const double turn = std::atan2(middle.y(), middle.x()) / (2.0 * kPi) + 1.0;
      Hulls& part = parts[static_cast<std::size_t>(turn * kParts) % kParts];
      for (int k = 0; k < 3; ++k) {
        part.box.add(mesh.corner(t, k));
        part.hull.add(mesh.corner(t, k));
      }
    }
    std::vector<Vec3> ends;
    for (int k = 0; k < 3; ++k) {
      const Vec3& p = mesh.corner(t, k);
      const Vec3& q = mesh.corner(t, (k + 1) % 3);
      if ((p.z() < 0.0) != (q.z() < 0.0)) ends.push_back(p + p.z() / (p.z() - q.z()) * (q - p));
    }
    if (ends.size() == 2) cut.line(ends[0], ends[1]);
  }
  Points boxes, hulls;
  double box_area = 0.0;
  double hull_area = 0.0;
  const auto add = [](Points& points, const Outline& polygon) {
    for (const auto& p : polygon) points.add({p.x(), p.y(), 0.0});
    points.add({polygon.front().x(), polygon.front().y(), 0.0}).gap();
    return area_of(polygon);
  };
  for (const Hulls& part : parts) {
    box_area += add(boxes, slice_of(part.box));
    hull_area += add(hulls, slice_of(part.hull));
  }
  std::string script = begin("hulls", 900, 780) + cut.block("cut") + boxes.block("boxes") + hulls.block("hulls");
  script += fmt::format(
      "set title 'Fixed Direction Hulls around twelve pieces of a ring''s outer wall, cut through the middle'\n"
      "set size ratio -1\n"
      "set xrange [-42:42]\n"
      "set yrange [-42:42]\n"
      "set xlabel 'mm' offset 0,0.4\n"
      "plot $boxes with lines linewidth 2 dashtype 2 linecolor rgb '{0}' title 'boxes: 6 directions, {3:.0f} mm^2 of the plane', \\\n "
      "$hulls with filledcurves closed fillcolor rgb '#c8dcf8' notitle, $hulls with lines linewidth 2.5 linecolor rgb '{1}' title 'FDH: 14 "
      "directions, {4:.0f} mm^2', \\\n $cut with lines linewidth 2 linecolor rgb '{2}' title 'the mesh'\n",
      kOrange, kBlue, "#202020", 1e6 * box_area, 1e6 * hull_area);
  return Figure{"hulls", script};
}

}  // namespace hapton::figures
