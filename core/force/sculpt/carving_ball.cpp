#include "core/force/sculpt/carving_ball.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/sliding_friction.h"

namespace hapton {
namespace {

// In voxels. The ball touches with a radius that is smaller by kRadiusMargin than the one with which it carves: by half a voxel that the
// centre may be ahead of the last carve, and by the error of linear interpolation inside a carve of two voxels' radius, 3 / (8 * 2)
// (decision 160).
constexpr double kRadiusMargin = 0.5 + 0.2;
constexpr double kCarveEvery = 0.5;   // motion of the centre from one carve to the next
constexpr double kInsideDepth = 0.2;  // a ball that begins deeper in the material counts as inside it
constexpr double kMaxStepS = 2e-3;    // s: a longer step, as after lost samples, cuts no farther than a step of this length
constexpr double kMinOffset = 1e-6;   // a shorter remainder of `shown_offset` or of the lag counts as zero

// The clearance of a ball that just fits into its own carve. Inside a carve of radius R the field is less than the distance by up to
// h^2 (1/R + 1/R + 1/R) / 8, since it is linear along each axis between nodes h apart, and by rounding.
double free_clearance(const SculptSettings& settings) {
  return (kRadiusMargin - 0.02 - 0.375 * settings.voxel_m / settings.tool_radius_m) * settings.voxel_m;
}

}  // namespace

CarvingBall::CarvingBall(const SculptSettings& settings)
    : settings_(settings), ball_(settings.tool_radius_m - kRadiusMargin * settings.voxel_m, settings.voxel_m) {}

void CarvingBall::reset(const Vec3& p_S) noexcept {
  state_ = {};
  state_.centre = p_S;
  state_before_ = state_;
}

void CarvingBall::note_restored_material(const CarvedField& field) noexcept {
  state_.carved_to.reset();
  if (!state_.has_begun || state_.is_inside || ball_.clearance_m(field, state_.centre) >= -kInsideDepth * settings_.voxel_m) return;
  state_.is_inside = true;
  state_.normal.setZero();
  state_.shown_offset.setZero();
  state_.lag_m = 0.0;
  state_.is_cutting = state_.is_sliding = false;
}

void CarvingBall::settle(const CarvedField& field, const Vec3& p_S, const Vec3& goal) noexcept {
  if (!state_.is_cutting || p_S == state_.centre) return;
  if (ball_.clearance_m(field, p_S) < -kInsideDepth * settings_.voxel_m) return;
  state_.centre = p_S;
  state_.lag_m = (goal - p_S).norm();
}

void CarvingBall::begin_sample(bool is_correction) noexcept {
  if (!is_correction) {
    state_before_ = state_;
    return;
  }
  const State last = state_;
  state_ = state_before_;
  if (state_before_.is_inside || !state_before_.has_begun) return;
  state_.centre = last.centre;
  state_.normal = last.normal;
}

CarvingBall::Felt CarvingBall::step(const Input& input, const Material& material, Sculpture& sculpture, std::size_t body) noexcept {
  begin_sample(input.is_correction);
  const CarvedField& field = sculpture.bodies()[body].field;
  const double voxel = settings_.voxel_m;
  if (!std::exchange(state_.has_begun, true)) state_.is_inside = ball_.clearance_m(field, state_.centre) < -kInsideDepth * voxel;
  if (state_.is_inside) {
    state_.centre = input.goal;
    state_.is_inside = ball_.clearance_m(field, state_.centre) < 0.0;
    return {.p_SP = input.goal};
  }
  const bool cuts = this->cuts(input.is_down, sculpture);
  state_.centre = cuts ? cut(input, sculpture, body) : touch(field, input, material);
  if (!cuts && std::exchange(state_.is_cutting, false)) {
    // The ball now rests on the bottom of its carve, kRadiusMargin away: the shown proxy goes there gradually.
    state_.shown_offset += state_before_.centre - state_.centre;
    state_.carved_to.reset();
  }
  state_.lag_m = (input.goal - state_.centre).norm();
  state_.shown_offset *= std::exp(-input.dt_s / kCutS);
  if (state_.shown_offset.norm() < kMinOffset * voxel) state_.shown_offset.setZero();
  const Vec3 shown =
      state_.shown_offset.isZero(0.0) ? state_.centre : ball_.advance(field, state_.centre, state_.centre + state_.shown_offset, 0.0);
  return {.p_SP = shown, .contact = shown != input.goal};
}

Vec3 CarvingBall::touch(const CarvedField& field, const Input& input, const Material& material) noexcept {
  const bool has_friction = material.friction_static > 0.0;
  const Vec3 goal = has_friction ? find_friction_goal(input.goal, state_.normal, material) : input.goal;
  FieldBall::Moved moved = ball_.move(field, state_.centre, goal);
  // The ball was held by friction alone, with no surface in its way: it moves freely.
  if (!moved.touches && goal != input.goal) moved = ball_.move(field, moved.centre, input.goal);
  state_.normal = moved.touches ? moved.normal : Vec3::Zero();
  return moved.centre;
}

// Coulomb friction as in the proxy method: moves the goal in the plane of the contact towards the proxy, by the length that friction holds.
Vec3 CarvingBall::find_friction_goal(const Vec3& goal, const Vec3& normal, const Material& material) noexcept {
  const Vec3 to_goal = goal - state_.centre;
  const double depth = -normal.dot(to_goal);
  if (normal.isZero(0.0) || !(depth > 0.0)) {
    state_.is_sliding = false;
    return goal;
  }
  const Vec3 pull = to_goal + depth * normal;
  const double length = pull.norm();
  if (state_.is_sliding && length <= FrictionMotion::kRestick * material.friction_dynamic * depth) state_.is_sliding = false;
  if (!state_.is_sliding && length > material.friction_static * depth) state_.is_sliding = true;
  const double held_length = state_.is_sliding ? material.friction_dynamic * depth : length;
  return length > 0.0 ? Vec3(goal - pull * std::min(1.0, held_length / length)) : goal;
}

// The position on the path through free space at which the lag behind the goal is what exponential decay (kCatchUpS) leaves of the old one.
Vec3 CarvingBall::catch_up(const Input& input, const Vec3& free_centre) const noexcept {
  const double remaining_lag_m = state_.lag_m * std::exp(-input.dt_s / kCatchUpS);
  const Vec3 to_goal_from_free = input.goal - free_centre;
  const Vec3 to_goal_from_centre = input.goal - state_.centre;
  const double length = to_goal_from_centre.norm();
  if (!(to_goal_from_free.norm() < remaining_lag_m) || remaining_lag_m < kMinOffset * settings_.voxel_m || !(length > 0.0))
    return free_centre;
  return input.goal - to_goal_from_centre * std::min(1.0, remaining_lag_m / length);
}

Vec3 CarvingBall::cut(const Input& input, Sculpture& sculpture, std::size_t body) noexcept {
  const CarvedField& field = sculpture.bodies()[body].field;
  const double voxel = settings_.voxel_m;
  state_.is_cutting = true;
  state_.is_sliding = false;
  state_.normal.setZero();
  const Vec3 free_centre = catch_up(input, ball_.advance(field, state_.centre, input.goal, free_clearance(settings_)));
  Vec3 cut_motion = (input.goal - free_centre) * -std::expm1(-input.dt_s / kCutS);
  const double longest_cut = kMaxCutSpeed * std::min(input.dt_s, kMaxStepS);
  if (cut_motion.norm() > longest_cut) cut_motion *= longest_cut / cut_motion.norm();
  const Vec3 centre = free_centre + cut_motion;
  const double clearance = ball_.clearance_m(field, centre);
  if (clearance > (kRadiusMargin + 1.0) * voxel) {
    state_.carved_to.reset();
    return centre;
  }
  const Vec3 from = state_.carved_to.value_or(centre);
  if (state_.carved_to && (centre - from).norm() < kCarveEvery * voxel) return centre;
  // Another body was carved in this step, and a step has only one carve: this ball goes no farther than through free space.
  if (sculpture.made()) return free_centre;
  sculpture.carve(body, {.from_m = from, .to_m = centre, .radius_m = settings_.tool_radius_m});
  state_.carved_to = centre;
  return centre;
}

}  // namespace hapton
