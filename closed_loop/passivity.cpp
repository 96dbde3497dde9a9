#include "closed_loop/passivity.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "core/math/dense_matrix.h"

namespace hapton {
namespace {

// Resolution of the search over frequencies: free choices that trade time for accuracy.
constexpr double kLowestTurn = 1e-3;  // rad over the whole delay; `slow_limit` is the limit of slower motions
constexpr int kPointsPerTurn = 24;    // frequencies evaluated for each turn over the delay, added to kMinPoints
constexpr int kMinPoints = 400;
constexpr int kAliases = 2000;  // on either side, added one by one if there is an amplifier

// The weights of the admittances at all aliases of one frequency: their sum, and the sum of their magnitudes.
struct AliasDisk {
  Complex centre;
  double radius = 0.0;
};

class FrequencySweep {
 public:
  explicit FrequencySweep(const PassivityCase& loop) : loop_(loop) {
    whole_periods_ = std::floor(loop.delay_s / loop.period_s + 1e-9);
    remainder_s_ = std::max(0.0, loop.delay_s - whole_periods_ * loop.period_s);
  }

  double find_least() const {
    if (!(loop_.damping_ns_per_m > 0.0)) return 0.0;
    // The limit for the slowest motions, which the wall's damping damps, too.
    const double slow_limit =
        (loop_.damping_ns_per_m + loop_.wall_damping_ns_per_m) / (0.5 * loop_.period_s + loop_.delay_s + loop_.amplifier_s);
    const double periods = (loop_.delay_s + loop_.amplifier_s) / loop_.period_s + 1.0;
    const double first = kLowestTurn / periods;
    const double last = std::max(2.0 * first, find_last(slow_limit));
    const int points = kMinPoints + static_cast<int>(kPointsPerTurn * periods * last / (2.0 * std::numbers::pi));
    double least = slow_limit;
    int least_index = 0;
    const double step = (last - first) / points;
    for (int i = 0; i <= points; ++i) {
      const double limit = limit_at(first + i * step);
      if (limit < least) least = limit, least_index = i;
    }
    return least_index == 0 ? least : refine(first + (least_index - 1) * step, std::min(first + (least_index + 1) * step, last), least);
  }

 private:
  // The angle above which no limit is below `slow_limit`: |q| (|centre| + radius) < 1 for K < (device - wall damping) 2 sin(angle / 2) / T.
  double find_last(double slow_limit) const {
    const double most = 2.0 * (loop_.damping_ns_per_m - loop_.wall_damping_ns_per_m) / loop_.period_s;
    return most > slow_limit ? 2.0 * std::asin(slow_limit / most) : std::numbers::pi;
  }

  // Searches by golden section around the least limit found so far.
  double refine(double low, double high, double least) const {
    const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
    for (int i = 0; i < 60; ++i) {
      const double left = high - golden * (high - low);
      const double right = low + golden * (high - low);
      const double at_left = limit_at(left);
      const double at_right = limit_at(right);
      least = std::min({least, at_left, at_right});
      (at_left < at_right ? high : low) = at_left < at_right ? right : left;
    }
    return least;
  }

  // The first K > 0 at which |1 - q centre| = |q| radius with q = q0 + K q1; 0 if K = 0 is already beyond this.
  double limit_at(double angle) const {
    const double half = std::sin(0.5 * angle);
    const Complex difference(2.0 * half * half, std::sin(angle));  // 1 - 1/z
    const AliasDisk disk = aliases(angle, difference);
    const Complex turn = std::polar(1.0, -std::remainder(angle * whole_periods_, 2.0 * std::numbers::pi));
    const Complex q1 = difference * turn / (2.0 * loop_.damping_ns_per_m * loop_.period_s);
    const Complex q0 = loop_.wall_damping_ns_per_m / loop_.period_s * difference * q1;
    const Complex away = 1.0 - q0 * disk.centre;
    const double c = std::norm(away) - std::norm(q0) * disk.radius * disk.radius;
    if (!(c > 0.0)) return 0.0;
    const double a = std::norm(q1) * (std::norm(disk.centre) - disk.radius * disk.radius);
    const double b = -2.0 * std::real(std::conj(away) * q1 * disk.centre) - 2.0 * std::real(std::conj(q0) * q1) * disk.radius * disk.radius;
    return first_root(a, b, c);
  }

  // The smallest positive root of a K^2 + b K + c; infinite if there is none. Pre: c > 0; a <= 0, except for rounding.
  static double first_root(double a, double b, double c) {
    const double discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0) return std::numeric_limits<double>::infinity();
    // With c in the numerator, the roots do not suffer from cancellation where a is nearly zero.
    const double root = std::sqrt(discriminant);
    const double first = -b + root > 0.0 ? 2.0 * c / (-b + root) : std::numeric_limits<double>::infinity();
    const double second = -b - root > 0.0 ? 2.0 * c / (-b - root) : std::numeric_limits<double>::infinity();
    return std::min(first, second);
  }

  AliasDisk aliases(double angle, const Complex& difference) const {
    const double t = loop_.period_s;
    if (loop_.amplifier_s > 0.0) return sum_aliases(angle);
    const Complex over = (1.0 - difference) / difference;  // z^-1 / (1 - z^-1)
    const double half = std::sin(0.5 * angle);
    return {-t * (t * over / difference - remainder_s_ * over), 0.25 * t * t / (half * half)};
  }

  // Adds the first aliases one by one and the rest as an integral; the weights fall with the cube of the frequency.
  AliasDisk sum_aliases(double angle) const {
    AliasDisk disk;
    const double t = loop_.period_s;
    for (int n = -kAliases; n <= kAliases; ++n) {
      const double w = (angle + 2.0 * std::numbers::pi * n) / t;
      const Complex weight = std::polar(1.0, -w * remainder_s_) / (w * w * Complex(1.0, w * loop_.amplifier_s));
      disk.centre += weight;
      disk.radius += std::abs(weight);
    }
    const double end = 2.0 * std::numbers::pi * (kAliases + 0.5) / t;
    disk.radius += t / (2.0 * std::numbers::pi) / (end * end * loop_.amplifier_s);
    return disk;
  }

  PassivityCase loop_;
  double whole_periods_ = 0.0;
  double remainder_s_ = 0.0;
};

}  // namespace

PassiveStiffness find_passive_stiffness(const PassivityCase& loop) {
  PassiveStiffness passive;
  passive.viscous_n_per_m = FrequencySweep(loop).find_least();
  passive.quantised_n_per_m =
      loop.encoder_step_m > 0.0 ? 2.0 * loop.friction_n / loop.encoder_step_m : std::numeric_limits<double>::infinity();
  return passive;
}

double linear_rule_n_per_m(double damping_ns_per_m, double period_s, double delay_s) noexcept {
  return damping_ns_per_m / (0.5 * period_s + delay_s);
}

}  // namespace hapton
