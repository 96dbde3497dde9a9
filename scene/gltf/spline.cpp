#include "scene/gltf/spline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hapton::gltf {
namespace {

constexpr double kToleranceShare = 1.0 / 256.0;

// One number between two keyframes, as a function of the share s of the time between them, 0 to 1. The tangents are derivatives by s.
struct Cubic {
  double start = 0.0;
  double start_slope = 0.0;
  double end = 0.0;
  double end_slope = 0.0;

  double at(double s) const {
    const double s2 = s * s;
    const double s3 = s2 * s;
    return (2.0 * s3 - 3.0 * s2 + 1.0) * start + (s3 - 2.0 * s2 + s) * start_slope + (3.0 * s2 - 2.0 * s3) * end + (s3 - s2) * end_slope;
  }
  // The second derivative is linear in s, so it is largest at an end.
  double max_second_derivative() const {
    return std::max(std::fabs(6.0 * (end - start) - 4.0 * start_slope - 2.0 * end_slope),
                    std::fabs(6.0 * (start - end) + 2.0 * start_slope + 4.0 * end_slope));
  }
};

Cubic cubic_of(const std::vector<double>& times, const std::vector<std::vector<double>>& rows, std::size_t i, std::size_t k) {
  const double span = times[i + 1] - times[i];
  return {rows[3 * i + 1][k], span * rows[3 * i + 2][k], rows[3 * i + 4][k], span * rows[3 * i + 3][k]};
}

// The largest range that one of the numbers covers on its curve.
double find_range(const std::vector<double>& times, const std::vector<std::vector<double>>& rows) {
  double range = 0.0;
  for (std::size_t k = 0; k < rows[0].size(); ++k) {
    double low = rows[1][k];
    double high = low;
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
      const Cubic cubic = cubic_of(times, rows, i, k);
      for (int n = 1; n <= kMaxPieces; ++n) {
        const double value = cubic.at(static_cast<double>(n) / kMaxPieces);
        low = std::min(low, value);
        high = std::max(high, value);
      }
    }
    range = std::max(range, high - low);
  }
  return range;
}

// A straight piece over 1/n of the share is off by at most an eighth of the second derivative, divided by n^2.
int count_pieces(double second_derivative, double tolerance) {
  if (!(second_derivative > 0.0) || !(tolerance > 0.0)) return 1;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(second_derivative / (8.0 * tolerance))), 1.0, static_cast<double>(kMaxPieces)));
}

}  // namespace

NumberTrack straighten_spline(const std::vector<double>& times, const std::vector<std::vector<double>>& rows) {
  NumberTrack track{{times[0]}, {rows[1]}};
  const double tolerance = kToleranceShare * find_range(times, rows);
  const std::size_t width = rows[1].size();
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    double second_derivative = 0.0;
    for (std::size_t k = 0; k < width; ++k)
      second_derivative = std::max(second_derivative, cubic_of(times, rows, i, k).max_second_derivative());
    const int pieces = count_pieces(second_derivative, tolerance);
    for (int n = 1; n < pieces; ++n) {
      const double s = static_cast<double>(n) / pieces;
      const double time = times[i] + s * (times[i + 1] - times[i]);
      if (!(time > track.times.back() && time < times[i + 1])) continue;
      track.times.push_back(time);
      std::vector<double>& row = track.values.emplace_back();
      for (std::size_t k = 0; k < width; ++k) row.push_back(cubic_of(times, rows, i, k).at(s));
    }
    track.times.push_back(times[i + 1]);
    track.values.push_back(rows[3 * i + 4]);
  }
  return track;
}

}  // namespace hapton::gltf
