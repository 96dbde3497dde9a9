#include "vision_node/screen_aspect.h"

#include <cmath>

#include <fmt/format.h>

namespace hapton {

std::string describe_aspect(const ScreenRectangle& screen, PictureSize size) {
  if (size.width_px <= 0 || size.height_px <= 0) return {};
  const double pixel_width_m = screen.width_m / size.width_px;
  const double pixel_height_m = screen.height_m / size.height_px;
  if (std::abs(std::log(pixel_width_m / pixel_height_m)) <= std::log1p(kMaxAspectShare)) return {};
  return fmt::format(
      "the picture has {}x{} pixels, and the screen of --screen {:.0f} x {:.0f} mm: make the window fill the area whose corners were "
      "touched, or run hapton screen again; until then things are not seen where they are felt",
      size.width_px, size.height_px, 1e3 * screen.width_m, 1e3 * screen.height_m);
}

}  // namespace hapton
