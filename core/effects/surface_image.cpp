#include "core/effects/surface_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

// The three control values around a place along one side of the image, their weights, and the derivatives of these by the place in texels.
struct SplineTaps {
  int index[3];
  double weight[3];
  double slope[3];
};

SplineTaps taps_of(double u, int size) noexcept {
  const double wrapped = std::isfinite(u) ? u - std::floor(u) : 0.0;
  const double place = wrapped * size;
  const int middle = std::min(static_cast<int>(place), size - 1);
  const double t = place - middle - 0.5;  // -1/2 to 1/2, from the texel's middle
  SplineTaps taps;
  taps.index[0] = middle > 0 ? middle - 1 : size - 1;
  taps.index[1] = middle;
  taps.index[2] = middle + 1 < size ? middle + 1 : 0;
  taps.weight[0] = 0.5 * (0.5 - t) * (0.5 - t);
  taps.weight[1] = 0.75 - t * t;
  taps.weight[2] = 0.5 * (0.5 + t) * (0.5 + t);
  taps.slope[0] = t - 0.5;
  taps.slope[1] = -2.0 * t;
  taps.slope[2] = t + 0.5;
  return taps;
}

}  // namespace

SurfaceImage::SurfaceImage(int width, int height, std::vector<float> texels) : width_(width), height_(height), texels_(std::move(texels)) {}

SurfaceImage::Sample SurfaceImage::sample(double u, double v) const noexcept {
  const SplineTaps across = taps_of(u, width_);
  const SplineTaps down = taps_of(v, height_);
  Sample sample;
  for (int j = 0; j < 3; ++j) {
    double value = 0.0;
    double slope = 0.0;
    for (int i = 0; i < 3; ++i) {
      const auto texel = static_cast<double>(at(across.index[i], down.index[j]));
      value += across.weight[i] * texel;
      slope += across.slope[i] * texel;
    }
    sample.value += down.weight[j] * value;
    sample.gradient.x() += down.weight[j] * slope;
    sample.gradient.y() += down.slope[j] * value;
  }
  sample.gradient.x() *= width_;
  sample.gradient.y() *= height_;
  return sample;
}

// Each derivative is a mean of differences of neighbours, with weights that are not negative, so it is at most the largest difference.
SurfaceImage::Vec2d SurfaceImage::steepest() const {
  Vec2d most = Vec2d::Zero();
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const auto here = static_cast<double>(at(x, y));
      most.x() = std::max(most.x(), std::abs(static_cast<double>(at((x + 1) % width_, y)) - here));
      most.y() = std::max(most.y(), std::abs(static_cast<double>(at(x, (y + 1) % height_)) - here));
    }
  }
  return {most.x() * width_, most.y() * height_};
}

SurfaceImage SurfaceImage::halved() const {
  const int width = std::max(1, width_ / 2);
  const int height = std::max(1, height_ / 2);
  std::vector<float> texels;
  texels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int x2 = std::min(2 * x + 1, width_ - 1);
      const int y2 = std::min(2 * y + 1, height_ - 1);
      texels.push_back(
          0.25F * (at(std::min(2 * x, x2), std::min(2 * y, y2)) + at(x2, std::min(2 * y, y2)) + at(std::min(2 * x, x2), y2) + at(x2, y2)));
    }
  }
  return {width, height, std::move(texels)};
}

}  // namespace hapton
