#pragma once

#include <span>

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"
#include "tools/loop/loop_flags.h"

namespace hapton {

// What one system holds: the least over its devices and hands.
struct HeldStiffness {
  const NamedLoop* by_device = nullptr;  // of which least is known; null: of none
  double device_n_per_m = 0.0;
  const NamedLoop* by_loop = nullptr;
  double safe_n_per_m = 0.0;  // half of the limit of stability, as hapton loop recommend has it
};
// Pre: loops is not empty and outlives the result; rate_hz > 0. RT: no, some 0.1 s.
HeldStiffness find_held_stiffness(std::span<const NamedLoop> loops, double rate_hz, double delay_s);

// An object stiffer than that. RT: set-up only.
CheckFindings check_stiffness(const SceneObject& object, const HeldStiffness& held, double rate_hz, double delay_s);
// A spring or a snap in free space.
CheckFindings check_stiffness(const SceneEffect& effect, const HeldStiffness& held, double rate_hz, double delay_s);

// A virtual mass in free space of more than half of what is stable, with its own filter, in the least of the loops. Pre: as above.
CheckFindings check_mass(const SceneEffect& effect, std::span<const NamedLoop> loops, double rate_hz, double delay_s);

}  // namespace hapton
