#include "core/force/sculpt/carving_ball.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/sliding_friction.h"

namespace hapton {
namespace {

// In voxels. The ball touches with a radius that is smaller by kRoom than the one with which it carves: by half a voxel that the centre may
// be ahead of the last carve, and by the error of linear interpolation inside a carve of two voxels' radius, 3 / (8 * 2) (decision 160).
constexpr double kRoom = 0.5 + 0.2;
constexpr double kCarveEvery = 0.5;  // motion of the centre from one carve to the next
constexpr double kInside = 0.2;      // a ball that begins deeper in the material counts as inside it
constexpr double kMaxStepS = 2e-3;   // s: a longer step, as after lost samples, cuts no farther than a step of this length
constexpr double kMinEase = 1e-6;    // a shorter remainder of `ease` or of the lag counts as zero

// The clearance of a ball that just fits into its own carve. Inside a carve of radius R the field is less than the distance by up to
// h^2 (1/R + 1/R + 1/R) / 8, since it is linear along each axis between nodes h apart, and by rounding.
double free_clearance(const SculptSettings& settings) {
  return (kRoom - 0.02 - 0.375 * settings.voxel_m / settings.tool_radius_m) * settings.voxel_m;
}

}  // namespace

CarvingBall::CarvingBall(const SculptSettings& settings)
    : settings_(settings), ball_(settings.tool_radius_m - kRoom * settings.voxel_m, settings.voxel_m) {}

void CarvingBall::reset(const Vec3& p_S) noexcept {
  now_ = {};
  now_.centre = p_S;
  before_ = now_;
}

void CarvingBall::meet_restored(const CarvedField& field) noexcept {
  now_.carved_to.reset();
  if (!now_.has_begun || now_.is_inside || ball_.clearance_m(field, now_.centre) >= -kInside * settings_.voxel_m) return;
  now_.is_inside = true;
  now_.normal.setZero();
  now_.ease.setZero();
  now_.lag_m = 0.0;
  now_.is_cutting = now_.is_sliding = false;
}

void CarvingBall::settle(const CarvedField& field, const Vec3& p_S, const Vec3& goal) noexcept {
  if (!now_.is_cutting || p_S == now_.centre) return;
  if (ball_.clearance_m(field, p_S) < -kInside * settings_.voxel_m) return;
  now_.centre = p_S;
  now_.lag_m = (goal - p_S).norm();
}

void CarvingBall::begin_sample(bool is_correction) noexcept {
  if (!is_correction) {
    before_ = now_;
    return;
  }
  const State last = now_;
  now_ = before_;
  if (before_.is_inside || !before_.has_begun) return;
  now_.centre = last.centre;
  now_.normal = last.normal;
}

CarvingBall::Felt CarvingBall::step(const Input& input, const Material& material, Sculpture& sculpture, std::size_t body) noexcept {
  begin_sample(input.is_correction);
  const CarvedField& field = sculpture.bodies()[body].field;
  const double voxel = settings_.voxel_m;
  if (!std::exchange(now_.has_begun, true)) now_.is_inside = ball_.clearance_m(field, now_.centre) < -kInside * voxel;
  if (now_.is_inside) {
    now_.centre = input.goal;
    now_.is_inside = ball_.clearance_m(field, now_.centre) < 0.0;
    return {.p_SP = input.goal};
  }
  const bool cuts = this->cuts(input.is_down, sculpture);
  now_.centre = cuts ? cut(input, sculpture, body) : touch(field, input, material);
  if (!cuts && std::exchange(now_.is_cutting, false)) {
    // The ball now rests on the bottom of its carve, kRoom away: the shown proxy goes there gradually.
    now_.ease += before_.centre - now_.centre;
    now_.carved_to.reset();
  }
  now_.lag_m = (input.goal - now_.centre).norm();
  now_.ease *= std::exp(-input.dt_s / kCutS);
  if (now_.ease.norm() < kMinEase * voxel) now_.ease.setZero();
  const Vec3 shown = now_.ease.isZero(0.0) ? now_.centre : ball_.advance(field, now_.centre, now_.centre + now_.ease, 0.0);
  return {.p_SP = shown, .contact = shown != input.goal};
}

Vec3 CarvingBall::touch(const CarvedField& field, const Input& input, const Material& material) noexcept {
  const bool has_friction = material.friction_static > 0.0;
  const Vec3 goal = has_friction ? find_friction_goal(input.goal, now_.normal, material) : input.goal;
  FieldBall::Moved moved = ball_.move(field, now_.centre, goal);
  // The ball was held by friction alone, with no surface in its way: it moves freely.
  if (!moved.touches && goal != input.goal) moved = ball_.move(field, moved.centre, input.goal);
  now_.normal = moved.touches ? moved.normal : Vec3::Zero();
  return moved.centre;
}

// Coulomb friction as in the proxy method: moves the goal in the plane of the contact towards the proxy, by the length that friction holds.
Vec3 CarvingBall::find_friction_goal(const Vec3& goal, const Vec3& normal, const Material& material) noexcept {
  const Vec3 to_goal = goal - now_.centre;
  const double depth = -normal.dot(to_goal);
  if (normal.isZero(0.0) || !(depth > 0.0)) {
    now_.is_sliding = false;
    return goal;
  }
  const Vec3 pull = to_goal + depth * normal;
  const double length = pull.norm();
  if (now_.is_sliding && length <= FrictionMotion::kRestick * material.friction_dynamic * depth) now_.is_sliding = false;
  if (!now_.is_sliding && length > material.friction_static * depth) now_.is_sliding = true;
  const double held = now_.is_sliding ? material.friction_dynamic * depth : length;
  return length > 0.0 ? Vec3(goal - pull * std::min(1.0, held / length)) : goal;
}

// The position on the path through free space at which the lag behind the goal is what exponential decay (kCatchUpS) leaves of the old one.
Vec3 CarvingBall::catch_up(const Input& input, const Vec3& free) const noexcept {
  const double kept_m = now_.lag_m * std::exp(-input.dt_s / kCatchUpS);
  const Vec3 left = input.goal - free;
  const Vec3 all = input.goal - now_.centre;
  const double length = all.norm();
  if (!(left.norm() < kept_m) || kept_m < kMinEase * settings_.voxel_m || !(length > 0.0)) return free;
  return input.goal - all * std::min(1.0, kept_m / length);
}

Vec3 CarvingBall::cut(const Input& input, Sculpture& sculpture, std::size_t body) noexcept {
  const CarvedField& field = sculpture.bodies()[body].field;
  const double voxel = settings_.voxel_m;
  now_.is_cutting = true;
  now_.is_sliding = false;
  now_.normal.setZero();
  const Vec3 free = catch_up(input, ball_.advance(field, now_.centre, input.goal, free_clearance(settings_)));
  Vec3 ahead = (input.goal - free) * -std::expm1(-input.dt_s / kCutS);
  const double most = kMaxCutSpeed * std::min(input.dt_s, kMaxStepS);
  if (ahead.norm() > most) ahead *= most / ahead.norm();
  const Vec3 centre = free + ahead;
  const double clearance = ball_.clearance_m(field, centre);
  if (clearance > (kRoom + 1.0) * voxel) {
    now_.carved_to.reset();
    return centre;
  }
  const Vec3 from = now_.carved_to.value_or(centre);
  if (now_.carved_to && (centre - from).norm() < kCarveEvery * voxel) return centre;
  // Another body was carved in this step, and a step has only one carve: this ball goes no farther than through free space.
  if (sculpture.made()) return free;
  sculpture.carve(body, {.from_m = from, .to_m = centre, .radius_m = settings_.tool_radius_m});
  now_.carved_to = centre;
  return centre;
}

}  // namespace hapton
