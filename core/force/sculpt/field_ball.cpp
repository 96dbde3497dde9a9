#include "core/force/sculpt/field_ball.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/force/contact_qp.h"

namespace hapton {
namespace {

constexpr double kMinPoints = 40.0;  // points of the smallest ball: about 30 degrees apart
// In spacings of the field:
constexpr double kRestOffset = 0.05;      // rest offset of the ball: more than rounding and the curvature of a step take from it
constexpr double kNearClearance = 0.5;    // points with a smaller clearance bound a step along the surface
constexpr double kSlideStep = 0.35;       // longest step along the surface; a step into the material is shortened
constexpr double kPushStep = 0.25;        // longest step out of the material
constexpr double kMinMove = 1e-5;         // a shorter step ends the search
constexpr double kCandidateRadius = 1.0;  // motion of the centre for which the chosen candidates stay valid
// Bounds of the work, for real time (decision 160 has the times):
constexpr double kShortenedShare = 0.35;  // share that is kept of a step that would end in the material
constexpr int kMaxEvaluations = 28;       // evaluations of the field at the points, in one move
constexpr int kMaxAdvanceSteps = 32;      // steps of one advance

}  // namespace

// The points lie on a spiral, each with the same area of the sphere (Vogel 1979, there for a disc).
FieldBall::FieldBall(double radius_m, double spacing_m) {
  const double area = 4.0 * std::numbers::pi * (radius_m / spacing_m) * (radius_m / spacing_m);
  const auto count = static_cast<std::size_t>(std::clamp(std::ceil(area), kMinPoints, double{kMaxPoints}));
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double across = std::sqrt(1.0 - z * z);
    const double angle = golden * static_cast<double>(i);
    points_.push_back(radius_m * Vec3(across * std::cos(angle), across * std::sin(angle), z));
  }
  points_.push_back(Vec3::Zero());
}

double FieldBall::clearance_m(const CarvedField& field, const Vec3& centre) const noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& point : points_) least = std::min(least, field.value(centre + point));
  return least;
}

FieldBall::Nearest FieldBall::find_nearest(const CarvedField& field, const Vec3& centre, Candidates& candidates) const noexcept {
  const double near_clearance = kNearClearance * field.spacing_m();
  Nearest nearest;
  nearest.clearance_m = std::numeric_limits<double>::infinity();
  const auto evaluate = [&](std::size_t i) {
    const double value = field.value(centre + points_[i]);
    nearest.clearance_m = std::min(nearest.clearance_m, value);
    if (value < near_clearance) insert(nearest, {i, value});
    return value;
  };
  if ((centre - candidates.centre).norm() <= candidates.valid_radius_m) {
    for (std::size_t k = 0; k < candidates.count; ++k) evaluate(candidates.points[k]);
    // The points that were left out have a clearance above `near_clearance`.
    nearest.clearance_m = std::min(nearest.clearance_m, near_clearance);
    return nearest;
  }
  candidates.count = 0;
  candidates.centre = centre;
  candidates.valid_radius_m = kCandidateRadius * field.spacing_m();
  const double reach = near_clearance + kSteepest * candidates.valid_radius_m;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (evaluate(i) < reach) candidates.points[candidates.count++] = static_cast<std::uint8_t>(i);
  }
  if (nearest.clearance_m >= near_clearance)
    candidates.valid_radius_m = -1.0;  // in free space the next step needs the clearance of all points
  return nearest;
}

void FieldBall::insert(Nearest& nearest, const NearPoint& one) noexcept {
  std::size_t slot = nearest.count;
  if (slot == kMaxPlanes) {
    if (one.value >= nearest.points[slot - 1].value) return;
    --slot;
  } else {
    ++nearest.count;
  }
  for (; slot > 0 && nearest.points[slot - 1].value > one.value; --slot) nearest.points[slot] = nearest.points[slot - 1];
  nearest.points[slot] = one;
}

// The longest step towards the goal that the tangent planes at the nearest points allow.
Vec3 FieldBall::slide(const CarvedField& field, const Vec3& centre, const Vec3& to_goal, const Nearest& nearest,
                      Moved& moved) const noexcept {
  const double spacing = field.spacing_m();
  std::array<ContactPlane, kMaxPlanes> planes;
  std::size_t count = 0;
  for (std::size_t i = 0; i < nearest.count; ++i) {
    const Vec3 gradient = field.gradient(centre + points_[nearest.points[i].point]);
    const double slope = gradient.norm();
    if (!(slope > 0.0)) continue;
    // A point below the rest offset keeps its height; one in the material is pushed out.
    const double value = nearest.points[i].value;
    const double height =
        value < 0.0 ? std::min(-value / slope, kPushStep * spacing) : std::min(0.0, kRestOffset * spacing - value) / slope;
    planes[count++] = {.normal = gradient / slope, .height = height};
  }
  const ConstrainedMotion allowed = constrain_motion(to_goal, std::span(planes.data(), count));
  Vec3 normal = Vec3::Zero();
  for (int i = 0; i < allowed.active_count; ++i) {
    normal += allowed.multipliers[i] * planes[allowed.active[i]].normal;
  }
  moved.normal = normal.norm() > 0.0 ? Vec3(normal.normalized()) : Vec3::Zero();
  const double length = allowed.motion.norm();
  const double most = kSlideStep * spacing;
  return length > most ? Vec3(allowed.motion * (most / length)) : allowed.motion;
}

FieldBall::Moved FieldBall::move(const CarvedField& field, const Vec3& from, const Vec3& goal) const noexcept {
  const double spacing = field.spacing_m();
  Moved moved{.centre = from};
  Candidates candidates;
  Nearest nearest = find_nearest(field, from, candidates);
  for (int evaluations = 1; evaluations < kMaxEvaluations;) {
    const Vec3 to_goal = goal - moved.centre;
    const double distance = to_goal.norm();
    if (!(distance > 0.0)) return {.centre = goal};
    moved.touches = true;
    if (nearest.count == 0) {
      candidates.valid_radius_m = -1.0;
      if (nearest.clearance_m <= kNearClearance * spacing) {  // only a lower bound so far: find the clearance itself
        nearest = find_nearest(field, moved.centre, candidates);
        ++evaluations;
      }
      const double free_distance = (nearest.clearance_m - 0.5 * kNearClearance * spacing) / kSteepest;
      if (free_distance >= distance) return {.centre = goal};
      moved.normal = Vec3::Zero();
      moved.centre += to_goal * (free_distance / distance);
      nearest = find_nearest(field, moved.centre, candidates);
      ++evaluations;
      continue;
    }
    Vec3 step = slide(field, moved.centre, to_goal, nearest, moved);
    // Each step ends clear of the material and nearer to the goal, so the ball comes to rest. A ball in the material leaves it first.
    const double least = std::min(0.0, nearest.clearance_m);
    Nearest next = find_nearest(field, moved.centre + step, candidates);
    ++evaluations;
    const auto is_good = [&] {
      return next.clearance_m >= least && (nearest.clearance_m < 0.0 || (to_goal - step).squaredNorm() < distance * distance);
    };
    for (; !is_good(); ++evaluations) {
      if (evaluations >= kMaxEvaluations || step.norm() < kMinMove * spacing) return moved;
      step *= kShortenedShare;
      next = find_nearest(field, moved.centre + step, candidates);
    }
    moved.centre += step;
    nearest = next;
    if (step.norm() < kMinMove * spacing) return moved;
  }
  return moved;
}

Vec3 FieldBall::advance(const CarvedField& field, const Vec3& from, const Vec3& goal, double least_m) const noexcept {
  const double shortest = 0.125 * field.spacing_m();
  const double distance = (goal - from).norm();
  if (!(distance > 0.0)) return goal;
  const Vec3 direction = (goal - from) / distance;
  double travelled = 0.0;
  double clearance = clearance_m(field, from);
  for (int i = 0; i < kMaxAdvanceSteps; ++i) {
    const double step = std::max((clearance - least_m) / kSteepest, shortest);
    const double next_travelled = std::min(travelled + step, distance);
    const double next_clearance = clearance_m(field, from + next_travelled * direction);
    if (next_clearance < least_m && next_clearance < clearance) break;
    if (next_travelled >= distance) return goal;
    travelled = next_travelled;
    clearance = next_clearance;
  }
  return from + travelled * direction;
}

}  // namespace hapton
