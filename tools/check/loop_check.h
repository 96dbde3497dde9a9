#pragma once

#include <span>

#include "core/force/stiffest.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"
#include "tools/loop/loop_flags.h"

namespace hapton {

// The largest gains safe with every device and hand of one system: half of each limit of stability, as hapton loop recommend says.
struct SafeGains {
  const NamedLoop* by_device = nullptr;  // each by_* is the loop with the least of the next value; null: no device states it
  double device_n_per_m = 0.0;           // the stiffness that the device is stated to hold, not halved
  const NamedLoop* by_loop = nullptr;
  double safe_n_per_m = 0.0;
  const NamedLoop* by_damping = nullptr;
  double damping_ns_per_m = 0.0;  // largest safe damping of a material
  const NamedLoop* by_viscosity = nullptr;
  double viscosity_ns_per_m = 0.0;        // largest safe viscosity of an effect
  const NamedLoop* by_turning = nullptr;  // null: no device has motors that turn the stylus
  double rotational_nm_per_rad = 0.0;     // largest safe rotational stiffness of a rigid tool's coupling (turning_axis.h)
  double pressed_n = kMaxPressedN;        // how hard surfaces are pressed: the strongest device's force, at most kMaxPressedN
};
// Pre: loops is not empty and outlives the result; rate_hz > 0. RT: no, about 0.1 s.
SafeGains find_safe_gains(std::span<const NamedLoop> loops, double rate_hz, double delay_s);

// Finds an object whose spring, bumps or stiffness map is stiffer than `gains`. RT: set-up only.
CheckFindings check_stiffness(const SceneObject& object, const SafeGains& gains, double rate_hz, double delay_s);
// The same for a spring, a snap or a gravity well in free space. RT: set-up only.
CheckFindings check_stiffness(const SceneEffect& effect, const SafeGains& gains, double rate_hz, double delay_s);

// Finds a rigid tool, or an object that the stylus picks up, whose rotational stiffness about its grip point, nm_per_rad, is above `gains`.
CheckFindings check_turning(const std::string& name, double nm_per_rad, const SafeGains& gains, double rate_hz, double delay_s);

// Finds an object that nobody feels: at a depth of 20 mm its spring has less force than the friction of every device, usually because its
// stiffness is meant in N/mm. An object with layers is not checked. RT: set-up only.
CheckFindings check_softness(const SceneObject& object, std::span<const NamedLoop> loops);

// Finds a damping, viscosity or drag of layers, or a viscous volume, above `gains`. is_touched_by_tool: by a rigid tool or by an object
// that the stylus has picked up; at its contacts damping uses the same smoothed velocity as viscosity does. RT: set-up only.
CheckFindings check_damping(const SceneObject& object, const SafeGains& gains, double rate_hz, double delay_s, bool is_touched_by_tool);
CheckFindings check_damping(const SceneEffect& effect, const SafeGains& gains, double rate_hz, double delay_s);

// Finds a virtual mass in free space above half of the largest that is stable, with its filter, in every loop. Pre: rate_hz > 0. RT: no.
CheckFindings check_mass(const SceneEffect& effect, std::span<const NamedLoop> loops, double rate_hz, double delay_s);

// Finds a surface whose layers give way only above the largest force of the weakest device, which therefore cannot render them; or one that
// snaps, rings or has a recorded texture with more force than that. RT: set-up only.
CheckFindings check_strength(const SceneObject& object, std::span<const NamedLoop> loops);
// Finds an effect whose largest force is above that of the weakest device. RT: set-up only.
CheckFindings check_strength(const SceneEffect& effect, std::span<const NamedLoop> loops);

// Finds a vibration at half the servo rate or above, which samples at that rate cannot render. RT: set-up only.
CheckFindings check_frequency(const SceneObject& object, double rate_hz);
CheckFindings check_frequency(const SceneEffect& effect, double rate_hz);

}  // namespace hapton
