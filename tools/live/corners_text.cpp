#include "tools/live/corners_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/number_list.h"

namespace hapton {
namespace {

bool read_corners(std::string_view text, ScreenCorners& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t end = i + 1 < corners.size() ? text.find(';') : text.size();
    if (end == std::string_view::npos) return false;
    const auto numbers = read_number_list(text.substr(0, end));
    if (!numbers || numbers->size() != 3) return false;
    corners[i] = Vec3(numbers->data());
    if (!corners[i].allFinite()) return false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return true;
}

}  // namespace

Result<ScreenCorners> parse_corners(std::string_view text) {
  ScreenCorners corners;
  if (read_corners(text, corners)) return corners;
  return fail(
      "--corners {}: give four points X,Y,Z in metres, separated by semicolons, without spaces, in quotes: lower left, lower right, upper "
      "right, upper left",
      text);
}

std::string describe_fit(const ScreenFit& fit) {
  const ScreenRectangle& screen = fit.screen;
  const Vec3 p_mm = 1e3 * screen.X_WR.translation();
  const Vec3 normal = screen.X_WR.linear().col(2);
  const double up_deg = std::asin(std::clamp(normal.y(), -1.0, 1.0)) * 180.0 / std::numbers::pi;
  const auto& r = fit.residuals_m;
  return fmt::format(
      "picture of {:.1f} x {:.1f} mm, its centre at {:.1f},{:.1f},{:.1f} mm, facing {:.1f} degrees up; the touched corners are {:.1f}, "
      "{:.1f}, "
      "{:.1f} and {:.1f} mm from it",
      1e3 * screen.width_m, 1e3 * screen.height_m, p_mm.x(), p_mm.y(), p_mm.z(), up_deg, 1e3 * r[0], 1e3 * r[1], 1e3 * r[2], 1e3 * r[3]);
}

}  // namespace hapton
