#include "core/effects/mapped_spring.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace hapton {
namespace {

using Row = std::array<double, 3>;

struct Range {
  double low = 0.0;
  double high = 0.0;

  void add(double x) noexcept {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};
Range single_value(double x) noexcept { return {x, x}; }

// Ranges over a part of a texel: of the value, and of its first and second derivatives by texture coordinates.
struct MapRanges {
  Range value, u, v, uu, uv, vv;
};

// A part of a texel. Coordinates are relative to the texel's middle, -1/2 to 1/2.
struct Part {
  std::array<double, 2> u = {-0.5, 0.5};
  std::array<double, 2> v = {-0.5, 0.5};
  int depth = 0;

  Part shrunk_to_middle() const noexcept {
    const double mu = 0.5 * (u[0] + u[1]);
    const double mv = 0.5 * (v[0] + v[1]);
    return {{mu, mu}, {mv, mv}, depth};
  }
};

// Polar form of the quadratic spline: s = t gives the weights at t; the two ends of an interval give its control points. The spline, and
// each of its derivatives, lies within the range of its own control points. (Ramshaw, Blossoming, 1987.)
Row weights(double s, double t) noexcept {
  const double before = 0.5 * (0.5 - s) * (0.5 - t);
  const double after = 0.5 * (0.5 + s) * (0.5 + t);
  return {before, 1.0 - before - after, after};
}
Row slopes(double t) noexcept { return {t - 0.5, -2.0 * t, t + 0.5}; }
constexpr Row kSecondDerivative = {1.0, -2.0, 1.0};

double dot(const Row& a, const Row& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// A texel and its eight neighbours: rows go down, along v.
struct Texels {
  std::array<Row, 3> at;

  double sum(const Row& across, const Row& down) const noexcept {
    return dot(down, {dot(across, at[0]), dot(across, at[1]), dot(across, at[2])});
  }
};

template <std::size_t a, std::size_t b>
Range range_of(const Texels& texels, const std::array<Row, a>& across, const std::array<Row, b>& down, double scale) noexcept {
  Range range = single_value(scale * texels.sum(across[0], down[0]));
  for (const Row& u : across) {
    for (const Row& v : down) range.add(scale * texels.sum(u, v));
  }
  return range;
}

// scale: the map's number per unit of a texel's value; width, height: image size in texels.
MapRanges ranges_of(const Texels& texels, const Part& part, const ImageMap& map) noexcept {
  const double scale = map.at_white - map.at_black;
  const double width = map.image->width();
  const double height = map.image->height();
  const auto value_points = [](const std::array<double, 2>& t) {
    return std::array<Row, 3>{weights(t[0], t[0]), weights(t[0], t[1]), weights(t[1], t[1])};
  };
  const auto slope_points = [](const std::array<double, 2>& t) { return std::array<Row, 2>{slopes(t[0]), slopes(t[1])}; };
  const std::array<Row, 1> bend = {kSecondDerivative};
  const auto value_u = value_points(part.u);
  const auto value_v = value_points(part.v);
  const auto slope_u = slope_points(part.u);
  const auto slope_v = slope_points(part.v);
  MapRanges ranges{.value = range_of(texels, value_u, value_v, scale),
                   .u = range_of(texels, slope_u, value_v, scale * width),
                   .v = range_of(texels, value_u, slope_v, scale * height),
                   .uu = range_of(texels, bend, value_v, scale * width * width),
                   .uv = range_of(texels, slope_u, slope_v, scale * width * height),
                   .vv = range_of(texels, value_u, bend, scale * height * height)};
  ranges.value.low += map.at_black;
  ranges.value.high += map.at_black;
  return ranges;
}

// Looser bounds over a whole texel, several times faster to compute: from the nine texels in place of control points.
MapRanges wide_ranges_of(const Texels& texels, const ImageMap& map) noexcept {
  const double scale = map.at_white - map.at_black;
  const double width = map.image->width();
  const double height = map.image->height();
  const auto& a = texels.at;
  Range value = single_value(a[0][0]), u = single_value(0.0), v = single_value(0.0), uu = single_value(a[0][0] - 2.0 * a[0][1] + a[0][2]),
        uv = single_value(0.0), vv = single_value(a[0][0] - 2.0 * a[1][0] + a[2][0]);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) value.add(a[i][j]);
    uu.add(a[i][0] - 2.0 * a[i][1] + a[i][2]);
    vv.add(a[0][i] - 2.0 * a[1][i] + a[2][i]);
    for (std::size_t j = 0; j < 2; ++j) {
      u.add(a[i][j + 1] - a[i][j]);
      v.add(a[j + 1][i] - a[j][i]);
      if (i < 2) uv.add(a[i + 1][j + 1] - a[i + 1][j] - a[i][j + 1] + a[i][j]);
    }
  }
  const auto scaled = [](const Range& range, double by) {
    return by >= 0.0 ? Range{by * range.low, by * range.high} : Range{by * range.high, by * range.low};
  };
  MapRanges ranges{.value = scaled(value, scale),
                   .u = scaled(u, scale * width),
                   .v = scaled(v, scale * height),
                   .uu = scaled(uu, scale * width * width),
                   .uv = scaled(uv, scale * width * height),
                   .vv = scaled(vv, scale * height * height)};
  ranges.value.low += map.at_black;
  ranges.value.high += map.at_black;
  return ranges;
}

double largest_eigenvalue_of(double trace, double determinant) noexcept {
  return 0.5 * (trace + std::sqrt(std::max(0.0, trace * trace - 4.0 * determinant)));
}

// How gradients along the surface follow from those in texture coordinates: |a du + b dv|^2 = (a, b) G (a, b)'. metric: the mean G of all
// triangles, by area. max_ratio: the least number with G <= max_ratio * metric for each triangle.
struct Mapping {
  Eigen::Matrix2d metric = Eigen::Matrix2d::Zero();
  double max_ratio = 0.0;

  explicit Mapping(const std::vector<MappedTriangle>& triangles) {
    double area = 0.0;
    for (const MappedTriangle& triangle : triangles) {
      const double weight = (triangle.corner[1] - triangle.corner[0]).cross(triangle.corner[2] - triangle.corner[0]).norm();
      metric += weight * metric_of(triangle);
      area += weight;
    }
    if (!(area > 0.0)) return;
    metric /= area;
    // If all texture coordinates lie on a line, the mean has no inverse. Adding this share of its trace gives it one, and changes the
    // result by at most a thousandth for a mapping that is up to a thousand times as long one way as the other.
    constexpr double kRegularization = 1e-9;
    metric += kRegularization * metric.trace() * Eigen::Matrix2d::Identity();
    if (!(metric.trace() > 0.0) || !metric.allFinite()) return;
    const Eigen::Matrix2d inverse = metric.inverse();
    for (const MappedTriangle& triangle : triangles) {
      const Eigen::Matrix2d ratio = inverse * metric_of(triangle);
      max_ratio = std::max(max_ratio, largest_eigenvalue_of(ratio.trace(), ratio.determinant()));
    }
  }

  static Eigen::Matrix2d metric_of(const MappedTriangle& triangle) {
    const MapPlace place = map_gradients(triangle);
    Eigen::Matrix2d metric;
    metric << place.du.squaredNorm(), place.du.dot(place.dv), place.du.dot(place.dv), place.dv.squaredNorm();
    return metric;
  }

  // Largest eigenvalue of the second derivative, and largest gradient, in a part of a texel: at ends of the ranges, as both are convex.
  double curvature(const MapRanges& ranges) const noexcept {
    double largest = 0.0;
    for (const double uv : {ranges.uv.low, ranges.uv.high}) {
      const double trace = metric(0, 0) * ranges.uu.high + 2.0 * metric(0, 1) * uv + metric(1, 1) * ranges.vv.high;
      const double determinant = metric.determinant() * (ranges.uu.high * ranges.vv.high - uv * uv);
      largest = std::max(largest, largest_eigenvalue_of(trace, determinant));
    }
    return max_ratio * largest;
  }
  double gradient(const MapRanges& ranges) const noexcept {
    double largest = 0.0;
    for (const double u : {ranges.u.low, ranges.u.high}) {
      for (const double v : {ranges.v.low, ranges.v.high})
        largest = std::max(largest, metric(0, 0) * u * u + 2.0 * metric(0, 1) * u * v + metric(1, 1) * v * v);
    }
    return std::sqrt(max_ratio * largest);
  }
};

Texels texels_around(const SurfaceImage& image, int x, int y) noexcept {
  const auto wrapped = [](int i, int size) { return i < 0 ? size - 1 : i >= size ? 0 : i; };
  Texels texels;
  for (int j = -1; j <= 1; ++j) {
    const auto row = static_cast<std::size_t>(wrapped(y + j, image.height())) * static_cast<std::size_t>(image.width());
    for (int i = -1; i <= 1; ++i) {
      const std::size_t at = row + static_cast<std::size_t>(wrapped(x + i, image.width()));
      texels.at[static_cast<std::size_t>(j + 1)][static_cast<std::size_t>(i + 1)] = static_cast<double>(image.texels()[at]);
    }
  }
  return texels;
}

// The largest value of a quantity anywhere in the image, times kMapMargin. bound(ranges): at least the largest value within these ranges,
// and exact if each range is a single number.
template <class Bound>
double find_largest(const ImageMap& map, const Bound& bound) {
  constexpr int kDeepest = 12;  // halvings of a texel; then the bound itself is the result
  double best = 0.0;
  std::vector<Part> parts;
  for (int y = 0; y < map.image->height(); ++y) {
    for (int x = 0; x < map.image->width(); ++x) {
      const Texels texels = texels_around(*map.image, x, y);
      if (!(bound(wide_ranges_of(texels, map)) > kMapMargin * best)) continue;
      parts.assign(1, Part());
      while (!parts.empty()) {
        const Part part = parts.back();
        parts.pop_back();
        const double most = bound(ranges_of(texels, part, map));
        if (!(most > kMapMargin * best)) continue;
        best = std::max(best, bound(ranges_of(texels, part.shrunk_to_middle(), map)));
        if (!(most > kMapMargin * best)) continue;
        if (part.depth == kDeepest) {
          best = most;
          continue;
        }
        const Part middle = part.shrunk_to_middle();
        for (const bool right : {false, true}) {
          for (const bool below : {false, true}) {
            parts.push_back({right ? std::array{middle.u[0], part.u[1]} : std::array{part.u[0], middle.u[0]},
                             below ? std::array{middle.v[0], part.v[1]} : std::array{part.v[0], middle.v[0]}, part.depth + 1});
          }
        }
      }
    }
  }
  return kMapMargin * best;
}

}  // namespace

double largest_curvature(const ImageMap& map, const std::vector<MappedTriangle>& triangles) {
  const Mapping mapping(triangles);
  if (!(mapping.max_ratio > 0.0)) return 0.0;
  return find_largest(map, [&](const MapRanges& ranges) { return mapping.curvature(ranges); });
}

// K in the plane of n and grad s is the matrix (s k + springs beside k, -f |grad s|; -f |grad s|, U curvature + sideways).
double MappedSpring::largest_n_per_m(const ImageMap& share_map, const std::vector<MappedTriangle>& triangles) const {
  const Mapping mapping(triangles);
  return find_largest(share_map, [&](const MapRanges& ranges) {
    const double force_n = pressed_n / ranges.value.low;
    const double along = sideways_n_per_m + 0.5 * force_n * force_n / spring_n_per_m * mapping.curvature(ranges);
    const double across = force_n * mapping.gradient(ranges);
    const double inward = ranges.value.high * spring_n_per_m + beside_n_per_m;
    return largest_eigenvalue_of(inward + along, inward * along - across * across);
  });
}

// The largest eigenvalue of -(v grad s' + grad s v') is |v| |grad s| - v . grad s, with v = n - grad h.
double MappedSpring::added_n_per_m(const ImageMap& share_map, const std::vector<MappedTriangle>& triangles, double slope) const {
  const Mapping mapping(triangles);
  return find_largest(share_map, [&](const MapRanges& ranges) {
    const double force_n = pressed_n / ranges.value.low;
    return force_n * mapping.gradient(ranges) * (std::sqrt(1.0 + slope * slope) + slope) +
           0.5 * force_n * force_n / spring_n_per_m * mapping.curvature(ranges);
  });
}

}  // namespace hapton
