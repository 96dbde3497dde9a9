#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/collision/swept_sphere.h"
#include "tools/figures/drawing.h"

namespace hapton::figures {
namespace {

// A triangle of the wall that an edge of the cross-section becomes when it is extended along z. The unit of all lengths in this file is one
// contact offset; it is drawn as a millimetre.
struct Wall {
  Vec3 a, b, c;
  Separation separation(const Vec3& p) const { return separation_from_triangle(p, a, b, c); }
};

std::vector<Wall> walls_along(const std::vector<std::vector<Eigen::Vector2d>>& polylines) {
  std::vector<Wall> walls;
  for (const auto& polyline : polylines) {
    for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
      const Vec3 p(polyline[i].x(), polyline[i].y(), 0.0);
      const Vec3 q(polyline[i + 1].x(), polyline[i + 1].y(), 0.0);
      const Vec3 deep(0.0, 0.0, 40.0);  // half the height of the wall, far more than the figure shows
      walls.push_back({p - deep, q - deep, q + deep});
      walls.push_back({p - deep, q + deep, p + deep});
    }
  }
  return walls;
}

// The share of the motion that a proxy can make from a point one contact offset above the surface until it is stopped; 1: all of it.
double find_free_share(const std::vector<Wall>& walls, const Vec3& from, const Vec3& motion) {
  const Clearance clearance = {.offset = 1.0, .slop = 0.5, .tolerance = 0x1p-10};
  double free_share = 1.0;
  for (const Wall& wall : walls) free_share = std::min(free_share, time_to_block(wall, from, motion, 1.0, clearance));
  return free_share;
}

}  // namespace

Result<Figure> draw_contact_offset() {
  const std::vector<std::vector<Eigen::Vector2d>> polylines = {
      {{-14, 0}, {-10.2, 0}}, {{-9.8, 0}, {-7.5, 0}, {-5.0, 3.0}, {-2.5, 0}, {2, 0}, {2, 0.4}, {6, 0.4}, {6, 1.1}, {11, 1.1}}};
  const std::vector<Wall> walls = walls_along(polylines);
  Points surface;
  for (const auto& polyline : polylines) {
    for (const auto& p : polyline) surface.add(1e-3 * Vec3(p.x(), p.y(), 0.0));
    surface.gap();
  }
  std::string field = "$field << EOD\n";
  for (double y = -3.0; y <= 5.0; y += 0.1) {
    for (double x = -14.0; x <= 11.001; x += 0.1) {
      double nearest = 1e9;
      for (const Wall& wall : walls) nearest = std::min(nearest, wall.separation({x, y, 0.3}).distance);
      fmt::format_to(std::back_inserter(field), "{:.3g} {:.3g} {:.4g}\n", x, y, nearest);
    }
    field += "\n";
  }
  field += "EOD\n";
  Points paths;
  const Vec3 low(-1.0, 1.0, 0.3);
  const double over_low = find_free_share(walls, low, {5.5, 0.0, 0.0});
  paths.add(1e-3 * low, 1e-3 * Vec3(5.5 * over_low, 0.0, 0.0));
  const Vec3 high(3.5, 1.4, 0.3);
  const double over_high = find_free_share(walls, high, {5.5, 0.0, 0.0});
  paths.add(1e-3 * high, 1e-3 * Vec3(5.5 * over_high, 0.0, 0.0));
  std::string script = begin("contact_offset", 1000, 490) + field + surface.block("surface") + paths.block("paths");
  script += fmt::format(
      "set table $levels\n"
      "set contour base\n"
      "set cntrparam levels discrete 1\n"
      "unset surface\n"
      "splot $field using 1:2:3\n"
      "unset table\n"
      "set table $low\n"
      "set cntrparam levels discrete 0.5\n"
      "splot $field using 1:2:3\n"
      "unset table\n"
      "set title 'A point probe is a sphere of one contact offset, 2^{{-30}} of the scene: cracks are as tight as faces'\n"
      "set size ratio -1\n"
      "set xrange [-14:11]\n"
      "set yrange [-3:4.6]\n"
      "set xlabel 'contact offsets' offset 0,0.4\n"
      "set label 1 \"crack narrower\\nthan contact offset\" at -10,-1.7 center\n"
      "set label 2 'convex edge' at -5,4.3 center\n"
      "set label 3 'concave edge' at -7.6,2.3 right\n"
      "set label 4 \"step of 0.4:\\n{3}\" at 1.6,-1.7 center\n"
      "set label 5 \"step of 0.7:\\n{4}\" at 7.8,-1.7 center\n"
      "plot $levels using 1:2 with lines linewidth 2.5 linecolor rgb '{0}' title 'rest: a proxy in contact is here (distance 1)', \\\n "
      "$low using 1:2 with lines linewidth 1.5 dashtype 2 linecolor rgb '{1}' title 'rest - slop: it never comes nearer (distance 1/2)', "
      "\\\n $surface with lines linewidth 4 linecolor rgb '#303030' title 'surface', \\\n $paths using 1:2:3:4 with vectors head filled "
      "size 0.35,18 linewidth 3 linecolor rgb '{2}' title 'a motion to the right'\n",
      kBlue, kRed, kGreen, over_low >= 1.0 ? "passed within the slop" : "stops", over_high >= 1.0 ? "passed" : "stops, then climbs");
  return Figure{"contact_offset", script};
}

}  // namespace hapton::figures
