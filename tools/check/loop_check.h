#pragma once

#include <span>

#include "core/force/stiffest.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"
#include "tools/loop/loop_flags.h"

namespace hapton {

// What one system holds: the least over its devices and hands. Half of each limit of stability, as hapton loop recommend has it.
struct HeldGains {
  const NamedLoop* by_device = nullptr;  // of which least is known; null: of none
  double device_n_per_m = 0.0;
  const NamedLoop* by_loop = nullptr;
  double safe_n_per_m = 0.0;
  const NamedLoop* by_damping = nullptr;
  double damping_ns_per_m = 0.0;  // of a material
  const NamedLoop* by_viscosity = nullptr;
  double viscosity_ns_per_m = 0.0;        // of an effect
  const NamedLoop* by_turning = nullptr;  // null: no motors of any turn the stylus
  double rotational_nm_per_rad = 0.0;     // of a rigid tool's coupling (turning_axis.h)
  double pressed_n = kMaxPressedN;        // how hard surfaces are pressed: the largest force of the strongest device
};
// Pre: loops is not empty and outlives the result; rate_hz > 0. RT: no, about 0.1 s.
HeldGains find_held_gains(std::span<const NamedLoop> loops, double rate_hz, double delay_s);

// An object stiffer than that, by its spring or by its bumps. RT: set-up only.
CheckFindings check_stiffness(const SceneObject& object, const HeldGains& held, double rate_hz, double delay_s);
// A spring, a snap or a gravity well in free space.
CheckFindings check_stiffness(const SceneEffect& effect, const HeldGains& held, double rate_hz, double delay_s);

// A rigid tool, or an object that becomes one, of that rotational stiffness about its grip.
CheckFindings check_turning(const std::string& name, double nm_per_rad, const HeldGains& held, double rate_hz, double delay_s);

// An object that nobody feels: at a depth of 20 mm its spring has less force than the friction of every device, usually because its
// stiffness is meant in N/mm. RT: set-up only.
CheckFindings check_softness(const SceneObject& object, std::span<const NamedLoop> loops);

// A damped or viscous surface, layers with drag, or a viscous volume, of more than that. is_touched_by_tool: by a rigid tool, or by an
// object that the stylus has picked up, whose contacts use the smoothed velocity of viscosity for damping, too. RT: set-up only.
CheckFindings check_damping(const SceneObject& object, const HeldGains& held, double rate_hz, double delay_s, bool is_touched_by_tool);
CheckFindings check_damping(const SceneEffect& effect, const HeldGains& held, double rate_hz, double delay_s);

// A virtual mass in free space of more than half of what is stable, with its own filter, in the least of the loops. Pre: as above.
CheckFindings check_mass(const SceneEffect& effect, std::span<const NamedLoop> loops, double rate_hz, double delay_s);

// A surface whose layers give way at a force above that of the weakest device, so that the device never gives what they resist with; or one
// that snaps, rings or has a recorded texture with more. RT: set-up only.
CheckFindings check_strength(const SceneObject& object, std::span<const NamedLoop> loops);
// An effect whose largest force is above that of the weakest device. RT: set-up only.
CheckFindings check_strength(const SceneEffect& effect, std::span<const NamedLoop> loops);

// A vibration of half the servo rate or more, which its samples cannot render. RT: set-up only.
CheckFindings check_frequency(const SceneObject& object, double rate_hz);
CheckFindings check_frequency(const SceneEffect& effect, double rate_hz);

}  // namespace hapton
