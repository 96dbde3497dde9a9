#include "core/tool/separating_planes.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

float rounded_up_plane(double x) { return static_cast<float>(x + std::fabs(x) * 0x1p-22 + 0x1p-100); }

// A sum of products in single precision: each of the two factors, the product and four additions are rounded, 7 * 2^-24 in all.
constexpr double kSumRounding = 0x1p-20;
constexpr double kLargestPlaneTurn = 0.25;  // with more, bounds of second order are of no use

struct TurnedShift {
  Vec3 shift;
  Vec3 turn;  // twice the vector part: as long as 2 sin(angle / 2)
  double length;
};

TurnedShift between(const Placement& a, const Placement& b) {
  const Quat q = b.orientation * a.orientation.conjugate();
  const Vec3 turn = (q.w() < 0.0 ? -2.0 : 2.0) * q.vec();
  return {b.position - a.position, turn, turn.norm()};
}

}  // namespace

SeparatingPlanes::SeparatingPlanes(std::size_t most, double radius) : radius_(radius), terms_(most), start_of_(most) {}

void SeparatingPlanes::begin(const SweptMotion& motion, double distance) noexcept {
  ++walk_;
  if (!(starts_[start_ % kMostStarts].placement == motion.from)) {
    if (++start_ == 0) {
      std::fill(start_of_.begin(), start_of_.end(), 0);
      start_ = kMostStarts;
    }
    starts_[start_ % kMostStarts].placement = motion.from;
  }
  from_ = motion.from;
  to_ = motion.to;
  least_ = rounded_up_plane(distance + motion.sagitta * radius_ + 0x1p-45 * (1.0 + radius_));
}

void SeparatingPlanes::see_from(Start& start) noexcept {
  start.walk = walk_;
  const auto see = [&](const Placement& placement, Terms& terms, float& slack) {
    const auto [shift, turn, length] = between(start.placement, placement);
    for (int k = 0; k < 3; ++k) {
      terms[k] = static_cast<float>(shift[k]);
      terms[4 + k] = static_cast<float>(turn[k]);
    }
    terms[3] = 1.0F;
    terms[7] = -static_cast<float>(length * (1.0 + kSumRounding));
    // R(w) a = a + w x a to within |a| |w|^2 (1/2 + |w|/4): 1 - cos is |w|^2 / 2, and |w| - sin is at most |w|^3 / 4. Middles of pieces,
    // and their radii, are at most sqrt(3) times the tool's radius, so that terms add up to |shift| + 2 sqrt(3) radius |w|.
    const double curved = 0.625 * length * length * radius_;
    const double rounding = kSumRounding * (shift.norm() + 4.0 * radius_ * length);
    slack = length <= kLargestPlaneTurn ? rounded_up_plane(curved + rounding) : std::numeric_limits<float>::infinity();
  };
  see(from_, start.from, start.slack_from);
  see(to_, start.to, start.slack_to);
}

void SeparatingPlanes::put(std::size_t i, const Plane& plane) noexcept {
  if (!(plane.gap > 0.0)) {
    start_of_[i] = 0;
    return;
  }
  Terms& terms = terms_[i];
  const Vec3 lever = plane.arm.cross(plane.normal);
  for (int k = 0; k < 3; ++k) {
    terms[k] = static_cast<float>(plane.normal[k]);
    terms[4 + k] = static_cast<float>(lever[k]);
  }
  terms[3] = static_cast<float>(plane.gap * (1.0 - kSumRounding));
  terms[7] = static_cast<float>(plane.radius * (1.0 + kSumRounding));
  start_of_[i] = start_;
}

}  // namespace hapton
