#include "bench/measure/sixdof_scenes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "bench/measure/gear_scenario.h"
#include "core/force/contact_qp.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr ToolCoupling kCoupling{.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.2};  // in all scenes; a free choice

Pose pose_of(const Vec3& p, const Vec3& turn = Vec3::Zero()) {
  Pose X = Pose::Identity();
  X.translation() = p;
  X.linear() = turn_by(turn).toRotationMatrix();
  return X;
}

std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) { return std::make_shared<const TriangleMesh>(std::move(mesh)); }

// Returns one pose for each step of 1 ms; `at` is called with the part of the run that is over, from 0 to 1.
std::vector<Pose> path_of(std::size_t steps, const std::function<Pose(double)>& at) {
  std::vector<Pose> path;
  for (std::size_t i = 0; i < steps; ++i) path.push_back(at(static_cast<double>(i) / static_cast<double>(steps)));
  return path;
}

// How far the tool is pressed in, as a share of its path: from 0, in free space, to 1 in the first fifth of the run, then back and forth
// between 1 and `shallow`.
double press(double t, double shallow) {
  if (t < 0.2) return 5.0 * t;
  return shallow + (1.0 - shallow) * (0.5 + 0.5 * std::cos(2.0 * kPi * 3.0 * (t - 0.2)));
}

// Finds where f is least in [low, high], by golden-section search. Pre: f has only one minimum in this range. A result within 1e-9 of 0 is
// returned as 0: the rounding of f hides the difference.
double find_minimum(double low, double high, const std::function<double(double)>& f) {
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  double a = high - ratio * (high - low);
  double b = low + ratio * (high - low);
  for (int i = 0; i < 200; ++i) {
    if (f(a) < f(b)) {
      high = b;
      b = a;
      a = high - ratio * (high - low);
    } else {
      low = a;
      a = b;
      b = low + ratio * (high - low);
    }
  }
  const double found = 0.5 * (low + high);
  return std::fabs(found) > 1e-9 ? found : 0.0;
}

double turn_about_y(const Pose& X) { return std::atan2(X.linear()(0, 2), X.linear()(2, 2)); }

// A cube with sides of 2 a that rests on the plane z = 0, turned about y by t, has its centre at z = a (|sin t| + cos t). The proxy is
// turned by the t of least energy.
SixdofScenario make_box_scenario(std::size_t steps, double tilt) {
  constexpr double kHalf = 0.01;  // m, like all lengths here; the sizes are free choices
  SixdofScenario made;
  made.name = tilt > 0.0 ? "tilted box on plane" : "box on plane";
  made.tool = shared(make_box(Vec3::Constant(2.0 * kHalf), 2));
  made.scene = shared(make_plane_grid(0.2, 10));
  made.coupling = kCoupling;
  made.device = path_of(steps, [&](double t) {
    return pose_of({0.01 * std::sin(9.0 * t), 0.013 * std::cos(7.0 * t), 0.017 - 0.010 * press(t, 0.5)},
                   {0.0, tilt * (0.8 + 0.2 * std::sin(11.0 * t)), 0.0});
  });
  made.expected = [coupling = made.coupling](const Pose& X) {
    const double z = X.translation().z();
    const double turn = turn_about_y(X);
    const auto height = [](double t) { return kHalf * (std::fabs(std::sin(t)) + std::cos(t)); };
    const auto energy = [&](double t) {
      const double depth = std::max(0.0, height(t) - z);
      return 0.5 * coupling.stiffness_n_per_m * depth * depth + 0.5 * coupling.rotational_stiffness_nm_per_rad * (t - turn) * (t - turn);
    };
    const double best = find_minimum(turn > 0.0 ? 0.0 : -0.25 * kPi, turn > 0.0 ? 0.25 * kPi : 0.0, energy);
    Wrench6 wrench;
    wrench.force_n.z() = coupling.stiffness_n_per_m * std::max(0.0, height(best) - z);
    if (wrench.force_n.z() > 0.0) wrench.torque_nm.y() = coupling.rotational_stiffness_nm_per_rad * (best - turn);
    return wrench;
  };
  return made;
}

// The axis of a cylinder of radius R in a groove with half the opening angle b can be anywhere in a wedge of the same opening, whose apex
// is R / sin b above that of the groove: the force pulls the axis to the nearest point of this wedge, and there is no torque.
SixdofScenario make_groove_scenario(std::size_t steps) {
  constexpr double kRadius = 0.008;
  constexpr double kHalfOpening = kPi / 4.0;
  constexpr double kSide = 0.1;
  constexpr double kDepth = 0.03;
  SixdofScenario made;
  made.name = "cylinder in V groove";
  made.tool = shared(make_cylinder(kRadius, 0.03, 256, 2));
  made.scene = shared(make_gutter(kSide, kDepth, 2.0 * kHalfOpening, 4));
  made.coupling = kCoupling;
  const double apex = 0.5 * kSide - kDepth + kRadius / std::sin(kHalfOpening);
  made.device = path_of(steps, [&](double t) {
    return pose_of({0.004 * std::sin(13.0 * t) * std::min(1.0, 5.0 * t), apex + 0.006 - 0.010 * press(t, 0.6), 0.01 * std::sin(5.0 * t)});
  });
  made.expected = [apex, coupling = made.coupling](const Pose& X) {
    const Vec3 p = X.translation() - Vec3(0.0, apex, 0.0);
    const Vec3 right(std::cos(kHalfOpening), std::sin(kHalfOpening), 0.0);  // the walls' normals
    const Vec3 left(-right.x(), right.y(), 0.0);
    const double a = -right.dot(p);
    const double b = -left.dot(p);
    Vec3 pull = std::max(a, 0.0) * right + std::max(b, 0.0) * left;  // the walls are perpendicular
    return Wrench6{coupling.stiffness_n_per_m * pull, Vec3::Zero()};
  };
  return made;
}

// A square peg of half width r and half length l between walls at x = -R and R: turned by t, its centre has |x| <= R - l |sin t| - r cos t.
SixdofScenario make_slot_scenario(std::size_t steps) {
  constexpr double kHalfWidth = 0.005;
  constexpr double kHalfLength = 0.015;
  constexpr double kHalfSlot = 0.0053;  // 0.3 mm of room on each side
  SixdofScenario made;
  made.name = "peg in slot";
  made.tool = shared(make_box({2.0 * kHalfWidth, 0.01, 2.0 * kHalfLength}, 3));
  TriangleMesh walls;
  for (const double side : {-1.0, 1.0}) {
    walls = joined(walls, scaled_and_moved(make_box({0.01, 0.08, 0.08}, 4), 1.0, {side * (kHalfSlot + 0.005), 0.0, 0.0}));
  }
  made.scene = shared(std::move(walls));
  made.coupling = kCoupling;
  made.device = path_of(steps, [&](double t) {
    return pose_of({0.003 * std::sin(8.0 * t), 0.005 * std::sin(5.0 * t), 0.005 * std::cos(4.0 * t)},
                   {0.0, 0.08 * std::sin(17.0 * t), 0.0});
  });
  made.expected = [coupling = made.coupling](const Pose& X) {
    const double x = X.translation().x();
    const double turn = turn_about_y(X);
    const auto room = [](double t) { return kHalfSlot - kHalfLength * std::fabs(std::sin(t)) - kHalfWidth * std::cos(t); };
    const auto place = [&](double t) { return std::clamp(x, -std::max(room(t), 0.0), std::max(room(t), 0.0)); };
    const auto energy = [&](double t) {
      const double off = place(t) - x;
      return 0.5 * coupling.stiffness_n_per_m * off * off + 0.5 * coupling.rotational_stiffness_nm_per_rad * (t - turn) * (t - turn);
    };
    // The peg can turn no farther than where it touches both walls.
    double low = 0.0;
    double high = 0.2;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (room(middle) >= 0.0 ? low : high) = middle;
    }
    const double best = find_minimum(turn > 0.0 ? 0.0 : -low, turn > 0.0 ? low : 0.0, energy);
    Wrench6 wrench;
    wrench.force_n.x() = coupling.stiffness_n_per_m * (place(best) - x);
    wrench.torque_nm.y() = coupling.rotational_stiffness_nm_per_rad * (best - turn);
    return wrench;
  };
  return made;
}

// A cone with flat sides and its apex at the origin, which opens upwards.
TriangleMesh make_cone(double height, double half_opening, int sides, bool with_lid) {
  TriangleMesh mesh;
  mesh.vertices.push_back(Vec3::Zero());
  const double radius = height * std::tan(half_opening);
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * kPi * i / sides;
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
  }
  mesh.vertices.emplace_back(0.0, 0.0, height);
  const auto lid = static_cast<std::uint32_t>(sides + 1);
  for (int i = 0; i < sides; ++i) {
    const auto a = static_cast<std::uint32_t>(1 + i);
    const auto b = static_cast<std::uint32_t>(1 + (i + 1) % sides);
    mesh.triangles.push_back({0, b, a});
    if (with_lid) mesh.triangles.push_back({lid, a, b});
  }
  return mesh;
}

// If the cone does not turn, its apex can be anywhere in a pit of the same shape. It does not turn, because it gets no torque: the force is
// normal to the line of contact and acts where the normal through the grip point meets that line. The sides are flat, so the nearest point
// of the pit is the nearest point of the intersection of the half-spaces above the sides.
SixdofScenario make_cone_scenario(std::size_t steps) {
  constexpr double kHalfOpening = kPi / 6.0;
  constexpr double kGrip = 0.012;  // m above the apex
  constexpr int kSides = 64;       // flat sides of each cone; a free choice
  SixdofScenario made;
  made.name = "cone in cone";
  made.tool = shared(scaled_and_moved(make_cone(0.02, kHalfOpening, kSides, true), 1.0, Vec3(0.0, 0.0, -kGrip)));
  made.scene = shared(make_cone(0.04, kHalfOpening, kSides, false));
  made.coupling = kCoupling;
  made.device = path_of(steps, [&](double t) {
    const double out = 0.004 * std::min(1.0, 4.0 * t);
    return pose_of({out * std::cos(9.0 * t), out * std::sin(9.0 * t), kGrip + 0.008 - 0.006 * press(t, 0.5)});
  });
  std::vector<ContactPlane> sides;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * kPi * (i + 0.5) / kSides;
    const double slope = std::tan(kHalfOpening) * std::cos(kPi / kSides);  // along the middle line of a side
    sides.push_back({Vec3(-std::cos(angle), -std::sin(angle), slope).normalized(), 0.0});
  }
  made.expected = [sides, coupling = made.coupling](const Pose& X) {
    Vec3 p = X.translation();
    p.z() -= kGrip;
    return Wrench6{coupling.stiffness_n_per_m * (constrain_motion(p, sides).motion - p), Vec3::Zero()};
  };
  return made;
}

}  // namespace

std::vector<SixdofScenario> make_analytic_scenarios(std::size_t steps) {
  return {make_box_scenario(steps, 0.0), make_box_scenario(steps, 0.25), make_groove_scenario(steps),
          make_slot_scenario(steps),     make_cone_scenario(steps),      make_gear_scenario(steps)};
}

SixdofScenario make_peg_scenario(std::size_t steps, std::uint64_t seed) {
  constexpr double kSide = 0.01;
  constexpr double kClearance = 20e-6;  // on each side: the narrowest hole of scenes/pegs.toml
  SixdofScenario made;
  made.name = "peg, 20 um clearance";
  made.tool = shared(make_box({kSide, kSide, 0.03}, 4));
  TriangleMesh walls;
  const double out = 0.5 * kSide + kClearance + 0.01;
  for (const double side : {-1.0, 1.0}) {
    walls = joined(walls, scaled_and_moved(make_box({0.02, 0.06, 0.02}, 4), 1.0, {side * out, 0.0, 0.0}));
    walls = joined(walls, scaled_and_moved(make_box({kSide + 2.0 * kClearance, 0.02, 0.02}, 4), 1.0, {0.0, side * out, 0.0}));
  }
  made.scene = shared(std::move(walls));
  made.coupling = kCoupling;
  // Along the hole the tool moves at most 100 mm/s: straight in, then to and fro. Across the hole, and in rotation, its motions are sums
  // of two sines, at most 2 rad/s about each axis.
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * kPi);
  const auto sines = [&](double largest, double rate) {
    const double a = phase(random);
    const double b = phase(random);
    return [=](double t) { return largest * (0.6 * std::sin(rate * t + a) + 0.4 * std::sin(1.7 * rate * t + b)); };
  };
  const auto x = sines(0.002, 9.0);
  const auto y = sines(0.002, 7.0);
  const auto turn_x = sines(0.1, 8.0);
  const auto turn_y = sines(0.1, 11.0);
  const auto turn_z = sines(0.1, 13.0);
  for (std::size_t i = 0; i < steps; ++i) {
    const double t = 1e-3 * static_cast<double>(i);
    const double begin = std::min(1.0, t);  // the sines grow from zero during the first second
    made.device.push_back(pose_of({begin * x(t), begin * y(t), t < 0.3 ? 0.03 - 0.1 * t : 0.012 * std::sin(8.0 * (t - 0.3))},
                                  begin * Vec3(turn_x(t), turn_y(t), turn_z(t))));
  }
  return made;
}

SixdofScenario make_size_scenario(std::size_t tool_triangles, std::size_t scene_triangles, std::size_t steps, std::uint64_t seed) {
  SixdofScenario made;
  made.tool = shared(make_bumpy_sphere(0.01, 0.1, tool_triangles, seed));
  made.scene = shared(make_bumpy_sphere(0.05, 0.1, scene_triangles, seed + 1));
  made.name = fmt::format("{} over {} triangles", made.tool->triangles.size(), made.scene->triangles.size());
  made.coupling = kCoupling;
  made.device = path_of(steps, [&](double t) {
    const double seconds = 1e-3 * static_cast<double>(steps) * t;
    const double out = 0.075 - 0.02 * std::min(1.0, 4.0 * t);
    const double angle = 1.5 * seconds;
    return pose_of({out * std::cos(angle), out * std::sin(angle), 0.01 * std::sin(2.0 * seconds)},
                   {0.5 * seconds, 1.1 * seconds, -0.7 * seconds});
  });
  return made;
}

}  // namespace hapton
