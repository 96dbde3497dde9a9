#pragma once

#include "bench/measure/sixdof_scenes.h"

namespace hapton {

// A spur gear with involute flanks about z, a tooth's middle on +x (or, with `between`, the middle of a gap). Units: m, rad.
struct SpurGear {
  int teeth = 20;                              // even
  double module_m = 0.002;                     // pitch circle of 40 mm
  double pressure_angle = 0.3490658503988659;  // 20 degrees
  double backlash_m = 2e-4;                    // of a pair of these: each tooth is thinner by half of it
  double width_m = 0.01;
  int flank_points = 48;  // corners of each flank; more: nearer to the involute

  double pitch_radius_m() const { return 0.5 * module_m * teeth; }
  double base_radius_m() const;
};

TriangleMesh make_spur_gear(const SpurGear& gear, bool between);

// The distance of the nearest flanks of two equal gears along their line of action: the first at the origin with a tooth's middle on +x,
// the second with its axis at `centre_m` (x, y), turned by `turn` from where the middle of a gap is on +x and on -x. counterclockwise:
// which flanks of the teeth. Below 0: they overlap. `slope`: its derivatives by x, y (1) and turn (m). Each flank is the involute of its
// base circle, of radius r: the path of the end of a string that unwinds from it, by the angles u1 and u2 here. So the common normal is an
// inner tangent of both base circles, and the distance is that tangent's length less the two strings: |C| sin a - r (u1 + u2), where C is
// centre_m and a the working pressure angle, cos a = 2 r / |C|. Pre: the base circles are apart.
double find_flank_gap(const SpurGear& gear, const Eigen::Vector2d& centre_m, double turn, bool counterclockwise, Vec3* slope = nullptr);

// A gear on the stylus meshes with a fixed one and is turned to and fro by up to 0.06 rad, a fifth of the tooth pitch, of which about
// 0.01 rad is play: force and torque are those of the least energy among the places (x, y, turn) where neither side's flanks overlap.
SixdofScenario make_gear_scenario(std::size_t steps);

}  // namespace hapton
