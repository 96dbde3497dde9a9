#include "core/force/sculpt/carving_ball.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

// In voxels. The ball touches with a radius that is smaller by kRoom than the one with which it carves: by half a voxel that the centre may
// be ahead of the last carve, and by the error of linear interpolation inside a carve of two voxels' radius, 3 / (8 * 2) (decision 160).
constexpr double kRoom = 0.5 + 0.2;
constexpr double kCarveEvery = 0.5;  // motion of the centre from one carve to the next
constexpr double kInside = 0.2;      // a ball that begins deeper in the material is inside
constexpr double kMostStepS = 2e-3;  // a longer step, as after lost samples, cuts no farther than this one
constexpr double kRestick = 0.5;     // as FrictionMotion::kRestick
constexpr double kLeastEase = 1e-6;  // a shorter rest of the room or of the lag counts as zero

// The clearance of a ball that just fits into its own carve. Inside a carve of radius R the field is less than the distance by up to
// h^2 (1/R + 1/R + 1/R) / 8, since it is linear along each axis between nodes h apart, and by rounding.
double free_clearance(const SculptSettings& settings) {
  return (kRoom - 0.02 - 0.375 * settings.voxel_m / settings.tool_radius_m) * settings.voxel_m;
}

}  // namespace

CarvingBall::CarvingBall(const SculptSettings& settings)
    : settings_(settings), ball_(settings.tool_radius_m - kRoom * settings.voxel_m, settings.voxel_m) {}

void CarvingBall::reset(const Vec3& p_S) noexcept {
  centre_ = p_S;
  normal_.setZero();
  ease_.setZero();
  lag_m_ = 0.0;
  carved_to_.reset();
  has_begun_ = is_inside_ = is_cutting_ = is_sliding_ = false;
}

void CarvingBall::meet_restored(const CarvedField& field) noexcept {
  carved_to_.reset();
  if (!has_begun_ || is_inside_ || ball_.clearance_m(field, centre_) >= -kInside * settings_.voxel_m) return;
  is_inside_ = true;
  normal_.setZero();
  ease_.setZero();
  lag_m_ = 0.0;
  is_cutting_ = is_sliding_ = false;
}

CarvingBall::Felt CarvingBall::step(const Input& input, const Material& material, Sculpture& sculpture, std::size_t body) noexcept {
  const CarvedField& field = sculpture.bodies()[body].field;
  const double voxel = settings_.voxel_m;
  if (!std::exchange(has_begun_, true)) is_inside_ = ball_.clearance_m(field, centre_) < -kInside * voxel;
  if (is_inside_) {
    centre_ = input.goal;
    is_inside_ = ball_.clearance_m(field, centre_) < 0.0;
    return {.p_SP = input.goal};
  }
  const bool cuts = input.is_down && !sculpture.is_full();
  const Vec3 before = centre_;
  centre_ = cuts ? cut(input, sculpture, body) : touch(field, input, material);
  if (!cuts && std::exchange(is_cutting_, false)) {
    // The ball now rests on the bottom of its carve, kRoom away: the shown proxy goes there gradually.
    ease_ += before - centre_;
    carved_to_.reset();
  }
  lag_m_ = (input.goal - centre_).norm();
  ease_ *= std::exp(-input.dt_s / kCutS);
  if (ease_.norm() < kLeastEase * voxel) ease_.setZero();
  const Vec3 shown = ease_.isZero(0.0) ? centre_ : ball_.advance(field, centre_, centre_ + ease_, 0.0);
  return {.p_SP = shown, .contact = shown != input.goal};
}

Vec3 CarvingBall::touch(const CarvedField& field, const Input& input, const Material& material) noexcept {
  const bool has_friction = material.friction_static > 0.0;
  const Vec3 goal = has_friction ? find_friction_goal(input.goal, normal_, material) : input.goal;
  const FieldBall::Moved moved = ball_.move(field, centre_, goal);
  normal_ = moved.touches ? moved.normal : Vec3::Zero();
  // The ball was held by friction alone, with no surface in its way: it moves freely.
  if (!moved.touches && goal != input.goal) {
    const FieldBall::Moved freed = ball_.move(field, moved.centre, input.goal);
    normal_ = freed.touches ? freed.normal : Vec3::Zero();
    return freed.centre;
  }
  return moved.centre;
}

// Coulomb friction as in the proxy method: moves the goal in the plane of the contact towards the proxy, by what friction holds.
Vec3 CarvingBall::find_friction_goal(const Vec3& goal, const Vec3& normal, const Material& material) noexcept {
  const Vec3 to_goal = goal - centre_;
  const double depth = -normal.dot(to_goal);
  if (normal.isZero(0.0) || !(depth > 0.0)) {
    is_sliding_ = false;
    return goal;
  }
  const Vec3 pull = to_goal + depth * normal;
  const double length = pull.norm();
  if (is_sliding_ && length <= kRestick * material.friction_dynamic * depth) is_sliding_ = false;
  if (!is_sliding_ && length > material.friction_static * depth) is_sliding_ = true;
  const double held = is_sliding_ ? material.friction_dynamic * depth : length;
  return length > 0.0 ? Vec3(goal - pull * std::min(1.0, held / length)) : goal;
}

// The position on the path through free space at which the lag behind the goal is what is left of it after exponential decay (kCatchUpS).
Vec3 CarvingBall::catch_up(const Input& input, const Vec3& free) const noexcept {
  const double kept_m = lag_m_ * std::exp(-input.dt_s / kCatchUpS);
  const Vec3 left = input.goal - free;
  const Vec3 all = input.goal - centre_;
  const double length = all.norm();
  if (!(left.norm() < kept_m) || kept_m < kLeastEase * settings_.voxel_m || !(length > 0.0)) return free;
  return input.goal - all * std::min(1.0, kept_m / length);
}

Vec3 CarvingBall::cut(const Input& input, Sculpture& sculpture, std::size_t body) noexcept {
  const CarvedField& field = sculpture.bodies()[body].field;
  const double voxel = settings_.voxel_m;
  is_cutting_ = true;
  is_sliding_ = false;
  normal_.setZero();
  const Vec3 free = catch_up(input, ball_.advance(field, centre_, input.goal, free_clearance(settings_)));
  Vec3 ahead = (input.goal - free) * -std::expm1(-input.dt_s / kCutS);
  const double most = kMostCutSpeed * std::min(input.dt_s, kMostStepS);
  if (ahead.norm() > most) ahead *= most / ahead.norm();
  const Vec3 centre = free + ahead;
  const double clearance = ball_.clearance_m(field, centre);
  if (clearance > (kRoom + 1.0) * voxel) {
    carved_to_.reset();
    return centre;
  }
  const Vec3 from = carved_to_.value_or(centre);
  if (carved_to_ && (centre - from).norm() < kCarveEvery * voxel) return centre;
  // Another body was carved in this step, and a step has one carve: this ball waits where it is.
  if (sculpture.made()) return free;
  sculpture.carve(body, {.from_m = from, .to_m = centre, .radius_m = settings_.tool_radius_m});
  carved_to_ = centre;
  return centre;
}

}  // namespace hapton
