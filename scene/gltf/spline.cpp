#include "scene/gltf/spline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hapton::gltf {
namespace {

constexpr double kShareOfRange = 1.0 / 256.0;

// One number between two keyframes, as a function of the share s of the time between them, 0 to 1. The tangents are derivatives by s.
struct Cubic {
  double from = 0.0;
  double leaving = 0.0;
  double to = 0.0;
  double arriving = 0.0;

  double at(double s) const {
    const double s2 = s * s;
    const double s3 = s2 * s;
    return (2.0 * s3 - 3.0 * s2 + 1.0) * from + (s3 - 2.0 * s2 + s) * leaving + (3.0 * s2 - 2.0 * s3) * to + (s3 - s2) * arriving;
  }
  // The second derivative is linear in s, so it is largest at an end.
  double most_bent() const {
    return std::max(std::fabs(6.0 * (to - from) - 4.0 * leaving - 2.0 * arriving),
                    std::fabs(6.0 * (from - to) + 2.0 * leaving + 4.0 * arriving));
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
int count_pieces(double most_bent, double tolerance) {
  if (!(most_bent > 0.0) || !(tolerance > 0.0)) return 1;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(most_bent / (8.0 * tolerance))), 1.0, static_cast<double>(kMaxPieces)));
}

}  // namespace

NumberTrack straighten_spline(const std::vector<double>& times, const std::vector<std::vector<double>>& rows) {
  NumberTrack track{{times[0]}, {rows[1]}};
  const double tolerance = kShareOfRange * find_range(times, rows);
  const std::size_t width = rows[1].size();
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    double most_bent = 0.0;
    for (std::size_t k = 0; k < width; ++k) most_bent = std::max(most_bent, cubic_of(times, rows, i, k).most_bent());
    const int pieces = count_pieces(most_bent, tolerance);
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
