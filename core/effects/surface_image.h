#pragma once

#include <vector>

#include "core/math/types.h"

namespace hapton {

// A grey image as a smooth function of texture coordinates: u to the right, v down, 0 to 1 across the image, periodic. Between texels it
// is the quadratic B-spline with the texels as its control values, so it and its gradient are continuous everywhere. It reproduces ramps
// exactly and lies between the darkest and the brightest texel around. Of the height of a sine with a period of n texels it keeps at
// least cos(pi / n)^2. RT: sample yes, everything else set-up only. Source: Schoenberg (1946); de Boor, A Practical Guide to Splines
// (1978), IX.
class SurfaceImage {
 public:
  using Vec2d = Eigen::Vector2d;
  struct Sample {
    double value = 0.0;
    Vec2d gradient = Vec2d::Zero();  // along u and v
  };

  // Pre: width and height are at least 1; width * height texels, finite, row by row from the upper left corner.
  SurfaceImage(int width, int height, std::vector<float> texels);

  // The image at u and v: any numbers; those that are not finite are taken as 0.
  Sample sample(double u, double v) const noexcept;

  // The largest slope anywhere along u, and that along v: each lies between two neighbouring texels.
  Vec2d steepest() const;
  // The image at half the resolution, each texel the mean of four. The last texel of an odd side is dropped; a side of 1 stays.
  SurfaceImage halved() const;

  int width() const { return width_; }
  int height() const { return height_; }
  const std::vector<float>& texels() const { return texels_; }

 private:
  float at(int x, int y) const noexcept {
    return texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }

  int width_;
  int height_;
  std::vector<float> texels_;
};

}  // namespace hapton
