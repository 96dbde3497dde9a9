#pragma once

#include "bench/measure/sixdof_scenes.h"

namespace hapton {

// A spur gear with involute flanks and the axis z. The middle of a tooth (with gap_on_x: of a gap) is on +x. Units: m, rad.
struct SpurGear {
  int teeth = 20;                              // must be even
  double module_m = 0.002;                     // gives a pitch circle of 40 mm
  double pressure_angle = 0.3490658503988659;  // 20 degrees
  double backlash_m = 2e-4;                    // backlash of a pair of these gears: each tooth is thinner by half of it
  double width_m = 0.01;
  int flank_chords = 48;  // chords that stand for the involute of each flank; a free choice

  double pitch_radius_m() const { return 0.5 * module_m * teeth; }
  double base_radius_m() const;
};

TriangleMesh make_spur_gear(const SpurGear& gear, bool gap_on_x);

// The gap between the nearest flanks of two equal gears along their line of action, m; below 0: they overlap. First gear: its axis at the
// origin, a tooth's middle on +x. Second gear: its axis at `centre_m` (x, y), turned by `turn` from the position in which the middles of
// gaps are on +x and on -x. counterclockwise: which of the two flanks of each tooth. `slope`: the gap's derivatives by x, y (1) and turn
// (m). Each flank is the involute of its base circle, of radius r: the path of the end of a string that unwinds from it, here by the angles
// u1 and u2. So the common normal is an inner tangent of both base circles, and the gap is that tangent's length less the two strings: |C|
// sin a - r (u1 + u2), where C is centre_m and a the working pressure angle, cos a = 2 r / |C|. Pre: the base circles are apart.
double find_flank_gap(const SpurGear& gear, const Eigen::Vector2d& centre_m, double turn, bool counterclockwise, Vec3* slope = nullptr);

// A gear on the stylus meshes with a fixed one and is turned to and fro by up to 0.06 rad, a fifth of the tooth pitch; about 0.01 rad of
// these are backlash. The expected force and torque are those at the position (x, y, turn) of least energy at which the flanks of neither
// side overlap.
SixdofScenario make_gear_scenario(std::size_t steps);

}  // namespace hapton
