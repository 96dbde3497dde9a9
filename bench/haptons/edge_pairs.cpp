#include "bench/haptons/edge_pairs.h"

#include <cmath>
#include <optional>
#include <random>

#include "bench/haptons/extended_pair.h"

namespace hapton {
namespace {

using Corners = std::array<Vec3, 3>;

class PairMaker {
 public:
  explicit PairMaker(const EdgePairSettings& settings) : settings_(settings), random_(settings.seed) {}

  // Moves b so that its edge 0-1 meets that of a, then along the common line of their planes into a. Empty: the drawn triangles do not fit.
  std::optional<TrianglePair> draw() {
    Corners a = make_triangle();
    Corners b = make_triangle();
    const Vec3 on_a = a[0] + between(0.1, 0.9) * (a[1] - a[0]);
    const Vec3 on_b = b[0] + between(0.1, 0.9) * (b[1] - b[0]);
    Vec3 line = normal_of(a).cross(normal_of(b));
    if (line.norm() < std::sin(kMinAngle)) return {};
    line.normalize();
    if (line.dot(inward(a)) < 0.0) line = -line;
    if (line.dot(inward(b)) > 0.0) return {};  // b would extend to the same side as a: a long contact
    const double length = settings_.size_m * std::exp(between(std::log(settings_.shallowest), std::log(settings_.deepest)));
    const Vec3 centre = settings_.spread_m * Vec3(between(-1, 1), between(-1, 1), between(-1, 1));
    for (Vec3& p : b) p += centre + on_a - on_b + length * line;
    for (Vec3& p : a) p += centre;
    const TrianglePair pair = {a, b};
    const ExtendedContact exact = intersect_extended(pair);
    if (exact.count != 2 || exact.on_edge_of_a[0] == exact.on_edge_of_a[1]) return {};
    return pair;
  }

 private:
  static constexpr double kMinAngle = 0.1745;  // rad, 10 degrees

  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 direction() {
    std::normal_distribution<double> normal;
    return Vec3(normal(random_), normal(random_), normal(random_)).normalized();
  }
  static Vec3 normal_of(const Corners& t) { return (t[1] - t[0]).cross(t[2] - t[0]).normalized(); }
  static Vec3 inward(const Corners& t) { return normal_of(t).cross(t[1] - t[0]); }

  static double least_angle(const Corners& t) {
    double least = 4.0;
    for (int i = 0; i < 3; ++i) {
      const Vec3 u = t[(i + 1) % 3] - t[i];
      const Vec3 v = t[(i + 2) % 3] - t[i];
      least = std::fmin(least, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
    return least;
  }
  Corners make_triangle() {
    Corners t;
    do {
      t = {direction(), direction(), direction()};
    } while (least_angle(t) < kMinAngle);
    const double longest = std::fmax((t[1] - t[0]).norm(), std::fmax((t[2] - t[1]).norm(), (t[0] - t[2]).norm()));
    for (Vec3& p : t) p *= settings_.size_m / longest;
    return t;
  }

  EdgePairSettings settings_;
  std::mt19937_64 random_;
};

}  // namespace

std::vector<TrianglePair> make_edge_pairs(const EdgePairSettings& settings) {
  PairMaker maker(settings);
  std::vector<TrianglePair> pairs;
  while (pairs.size() < settings.count) {
    if (const auto pair = maker.draw()) pairs.push_back(*pair);
  }
  return pairs;
}

}  // namespace hapton
