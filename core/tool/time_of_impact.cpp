#include "core/tool/time_of_impact.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

using Kind = FeaturePair::Kind;

// How long, from t = 0 on, above + rate t - bend t^2 / 2 stays at 0 or more, with above = distance - floor. By rounding, a distance at its
// floor may be a little below it. Pre: bend >= 0.
double time_above(double distance, double floor, double rate, double bend) {
  constexpr double kRounding = 0x1p-24;  // share of the floor, which is 2^30 times the rounding of a distance
  double above = distance - floor;
  if (!(above > -kRounding * floor)) return 0.0;
  above = std::max(above, 0.0);
  const double root = std::sqrt(rate * rate + 2.0 * bend * above);
  if (rate < 0.0) return 2.0 * above / (root - rate);
  if (bend > 0.0) return (rate + root) / bend;
  return rate > 0.0 || above > 0.0 ? 1e300 : 1.0;
}

// The velocity of a rigid motion at one instant, and bounds of accelerations. Positions are from the grip point at that instant.
struct MotionRates {
  Vec3 shift;
  Vec3 turn;
  double turn_squared;
  double turn_length;
  double shift_length;

  explicit MotionRates(const RigidMotion& motion)
      : shift(motion.shift),
        turn(motion.turn),
        turn_squared(motion.turn.squaredNorm()),
        turn_length(std::sqrt(turn_squared)),
        shift_length(motion.shift.norm()) {}

  Vec3 velocity(const Vec3& arm) const { return shift + turn.cross(arm); }
  // Largest acceleration of a point of the tool, and, in the tool's frame, of a fixed point of the scene.
  double acceleration_of_tool(const Vec3& arm) const { return turn_squared * arm.norm(); }
  double acceleration_of_scene(const Vec3& arm) const {
    return turn_squared * (arm.norm() + shift_length) + 2.0 * turn_length * shift_length;
  }
};

double vertex_face_time(const FeatureGap& gap, const MotionRates& rates, double floor) {
  return time_above(gap.distance, floor, gap.normal.dot(rates.velocity(gap.on_tool)), rates.acceleration_of_tool(gap.on_tool));
}

double face_vertex_time(const FeatureGap& gap, const MotionRates& rates, const Vec3& position, double floor) {
  const Vec3 arm = gap.on_scene - position;
  return time_above(gap.distance, floor, gap.normal.dot(rates.velocity(arm)), rates.acceleration_of_scene(arm));
}

// The time for which the lines through the edges stay on the same side of each other, farther apart than the floor:
// w . (d x e) > floor |d x e| for unit d, e and w from a point of one line to a point of the other.
double line_time(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement, const MotionRates& rates, double floor) {
  const Vec3 d = (placement.orientation * (pair.tool[1] - pair.tool[0])).normalized();
  const Vec3 e = (pair.scene[1] - pair.scene[0]).normalized();
  Vec3 normal = d.cross(e);
  const Vec3 w = gap.distance * gap.normal;
  const double side = w.dot(normal) < 0.0 ? -1.0 : 1.0;
  normal *= side;
  const Vec3 velocity = rates.velocity(gap.on_tool);
  const Vec3 d1 = rates.turn.cross(d);  // derivatives of d with respect to time
  const Vec3 d2 = rates.turn.cross(d1);
  const Vec3 normal_rate = side * d1.cross(e);
  const double rate = velocity.dot(normal) + w.dot(normal_rate) - floor * rates.turn_length;
  const double second =
      rates.turn.cross(rates.turn.cross(gap.on_tool)).dot(normal) + 2.0 * velocity.dot(normal_rate) + side * w.dot(d2.cross(e));
  const double speed = rates.shift_length + rates.turn_length * gap.on_tool.norm();
  // Third derivative: w''' . (d x e) + 3 w'' . (d' x e) + 3 w' . (d'' x e) + w . (d''' x e).
  const double third =
      rates.turn_squared * (4.0 * rates.turn_length * gap.on_tool.norm() + 3.0 * speed + rates.turn_length * (gap.distance + speed));
  return time_above(w.dot(normal), floor * normal.norm(), rate, std::max(0.0, third / 3.0 - second));
}

// The time for which a plane that is fixed in the scene, or one fixed in the tool, separates the edges. If the first does up to `until`,
// the second is not computed.
double plane_time(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement, const MotionRates& rates, double floor,
                  double until) {
  const Vec3& n = gap.normal;
  const double scene_top = std::max(n.dot(pair.scene[0]), n.dot(pair.scene[1]));
  double tool_low = 1e300;
  double in_scene = 1e300;
  for (int k = 0; k < 2; ++k) {
    const Vec3 arm = placement.orientation * pair.tool[k];
    const double height = n.dot(placement.position + arm);
    tool_low = std::min(tool_low, height);
    in_scene = std::min(in_scene, time_above(height - scene_top, floor, n.dot(rates.velocity(arm)), rates.acceleration_of_tool(arm)));
  }
  if (in_scene >= until) return in_scene;
  double in_tool = 1e300;
  for (int k = 0; k < 2; ++k) {
    const Vec3 arm = pair.scene[k] - placement.position;
    in_tool =
        std::min(in_tool, time_above(tool_low - n.dot(pair.scene[k]), floor, n.dot(rates.velocity(arm)), rates.acceleration_of_scene(arm)));
  }
  return std::max(in_scene, in_tool);
}

// True if the pairs of the edges' ends with faces suffice: between the ends the distance changes by no more than the sine times the length.
bool is_covered_by_ends(const FeaturePair& pair, const Placement& placement, const MotionRates& rates, double floor) {
  const Vec3 d = placement.orientation * (pair.tool[1] - pair.tool[0]);
  const Vec3 e = pair.scene[1] - pair.scene[0];
  const double shorter = std::sqrt(std::min(d.squaredNorm(), e.squaredNorm()));
  const double sine = d.cross(e).norm() / std::sqrt(d.squaredNorm() * e.squaredNorm());
  return !(shorter * (sine + rates.turn_length) > 0.25 * floor);
}

// A lower bound of the time at which the pair reaches its floor. If a cheap bound is `until` or more, it is returned, and the better ones
// are not computed.
double advance_time(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement, const MotionRates& rates, double floor,
                    double until) {
  switch (pair.kind) {
    case Kind::vertex_face:
      return vertex_face_time(gap, rates, floor);
    case Kind::face_vertex:
      return face_vertex_time(gap, rates, placement.position, floor);
    case Kind::edge_edge:
      break;
  }
  const double by_plane = plane_time(pair, gap, placement, rates, floor, until);
  if (by_plane >= until || gap.feature != TriangleFeature::face) return by_plane;
  return std::max(by_plane, line_time(pair, gap, placement, rates, floor));
}

}  // namespace

double bound_time_of_impact(const FeaturePair& pair, const FeatureGap& gap, const RigidMotion& motion, double floor,
                            double until) noexcept {
  // Share of the whole motion: if an advance is shorter, the pair has reached its floor.
  constexpr double kMinAdvance = 0x1p-12;
  const MotionRates rates(motion);
  if (pair.kind == Kind::edge_edge && is_covered_by_ends(pair, motion.from, rates, floor)) return until;
  double time = advance_time(pair, gap, motion.from, rates, floor, until);
  for (int advance = 1; time < until && advance < kMaxAdvances; ++advance) {
    const Placement placement = motion.at(time);
    const double advance_share = advance_time(pair, measure_gap(pair, placement), placement, rates, floor,
                                              2.0 * (until - time));  // exceeds the rest of the motion by more than rounding
    time += advance_share;
    if (advance_share < kMinAdvance) break;
  }
  return std::min(time, until);
}

}  // namespace hapton
