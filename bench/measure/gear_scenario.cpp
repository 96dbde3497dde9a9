#include "bench/measure/gear_scenario.h"

#include <cmath>
#include <numbers>

#include "core/force/contact_qp.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// The polar angle of an involute, from its start to the point at which the string has unwound by the angle t: t - atan t.
double involute_turn(double t) { return t - std::atan(t); }

// Half the angle of a tooth at its base circle.
double half_tooth_at_base(const SpurGear& gear) {
  const double thickness = 0.5 * std::numbers::pi * gear.module_m - 0.5 * gear.backlash_m;
  return 0.5 * thickness / gear.pitch_radius_m() + involute_turn(std::tan(gear.pressure_angle));
}

// The outline of the gear, counter-clockwise. gap_on_x: a gap, not a tooth, is at angle 0.
std::vector<Eigen::Vector2d> make_outline(const SpurGear& gear, bool gap_on_x) {
  const double base = gear.base_radius_m();
  const double root = gear.pitch_radius_m() - 1.25 * gear.module_m;
  const double tip = gear.pitch_radius_m() + gear.module_m;
  const double last = std::sqrt(tip * tip / (base * base) - 1.0);
  const double pitch = 2.0 * std::numbers::pi / gear.teeth;
  const double half = half_tooth_at_base(gear);
  std::vector<Eigen::Vector2d> outline;
  const auto add = [&](double radius, double angle) { outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle)); };
  for (int tooth = 0; tooth < gear.teeth; ++tooth) {
    const double middle = pitch * (tooth + (gap_on_x ? 0.5 : 0.0));
    add(root, middle - half);
    for (int i = 0; i <= gear.flank_chords; ++i) {
      const double t = last * i / gear.flank_chords;
      add(base * std::sqrt(1.0 + t * t), middle - half + involute_turn(t));
    }
    for (int i = gear.flank_chords; i >= 0; --i) {
      const double t = last * i / gear.flank_chords;
      add(base * std::sqrt(1.0 + t * t), middle + half - involute_turn(t));
    }
    add(root, middle + half);
  }
  return outline;
}

double turn_about_z(const Pose& X) { return std::atan2(X.linear()(1, 0), X.linear()(0, 0)); }

// Finds the pose (x, y, turn) of least energy at which no flanks overlap. Each round linearises the gaps of both sides at the last pose;
// the number of rounds is a free choice.
Vec3 find_equilibrium(const SpurGear& gear, const Vec3& device, double turn_length_m) {
  const Vec3 scale(1.0, 1.0, turn_length_m);
  Vec3 at = device;
  for (int round = 0; round < 60; ++round) {
    std::array<ContactPlane, 2> planes;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      Vec3 slope;
      const double gap = find_flank_gap(gear, at.head<2>(), at.z(), i == 0, &slope);
      // In lengths, with y the motion from the device to the pose: gap + slope . (y + device - at) >= 0.
      const Vec3 scaled = slope.cwiseQuotient(scale);
      planes[i] = {scaled.normalized(), (slope.dot(at - device) - gap) / scaled.norm()};
    }
    const Vec3 motion = constrain_motion(Vec3::Zero(), planes).motion;
    at = device + motion.cwiseQuotient(scale);
  }
  return at;
}

}  // namespace

double SpurGear::base_radius_m() const { return pitch_radius_m() * std::cos(pressure_angle); }

TriangleMesh make_spur_gear(const SpurGear& gear, bool gap_on_x) { return make_prism(make_outline(gear, gap_on_x), gear.width_m, 1); }

double find_flank_gap(const SpurGear& gear, const Eigen::Vector2d& centre_m, double turn, bool counterclockwise, Vec3* slope) {
  // The clockwise side is the mirror image of the counterclockwise side.
  const double side = counterclockwise ? 1.0 : -1.0;
  const double base = gear.base_radius_m();
  const double pitch = 2.0 * std::numbers::pi / gear.teeth;
  const double distance = centre_m.norm();
  const double pressure = std::acos(2.0 * base / distance);
  const double direction = std::atan2(side * centre_m.y(), centre_m.x());
  const double along = direction - pressure;  // angle at which the tangent touches the first base circle
  // The sum of both strings' angles, for tooth 0 of the first gear and the next tooth of the second; other pairs differ by whole teeth.
  const double strings = 2.0 * half_tooth_at_base(gear) + (side * turn + 0.5 * pitch) - 2.0 * along;
  const double gap = distance * std::sin(pressure) - base * strings;
  if (slope != nullptr) *slope = {-std::sin(along), side * std::cos(along), -side * base};
  return gap - base * pitch * std::round(gap / (base * pitch));
}

SixdofScenario make_gear_scenario(std::size_t steps) {
  const SpurGear fixed;
  SpurGear held;
  held.width_m = 0.006;
  SixdofScenario made;
  made.name = "gear pair";
  made.tool = std::make_shared<const TriangleMesh>(make_spur_gear(held, true));
  made.scene = std::make_shared<const TriangleMesh>(make_spur_gear(fixed, false));
  made.coupling = {.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.2};
  for (std::size_t i = 0; i < steps; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(steps);
    const double begin = std::min(1.0, 5.0 * t);
    Pose X = Pose::Identity();
    X.translation() = Vec3(2.0 * fixed.pitch_radius_m() + 2e-4 + 1e-4 * begin * std::sin(13.0 * t), 1e-4 * begin * std::sin(9.0 * t),
                           1e-3 * std::sin(5.0 * t));
    X.linear() = turn_by({0.0, 0.0, 0.06 * begin * std::sin(20.0 * t)}).toRotationMatrix();
    made.device.push_back(X);
  }
  made.expected = [fixed, coupling = made.coupling](const Pose& X) {
    const Vec3 device(X.translation().x(), X.translation().y(), turn_about_z(X));
    const Vec3 equilibrium =
        find_equilibrium(fixed, device, std::sqrt(coupling.rotational_stiffness_nm_per_rad / coupling.stiffness_n_per_m));
    Wrench6 wrench;
    wrench.force_n.head<2>() = coupling.stiffness_n_per_m * (equilibrium - device).head<2>();
    wrench.torque_nm.z() = coupling.rotational_stiffness_nm_per_rad * (equilibrium.z() - device.z());
    return wrench;
  };
  return made;
}

}  // namespace hapton
