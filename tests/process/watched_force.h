#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/process/system.h"

namespace hapton::process {

// Limits so tight that a fault comes near them; tight_limits() also requests a probe state for each sample.
constexpr double kMaxForceN = 1.5;
constexpr double kMaxSlewNPerS = 100.0;
// Options of io_node; touch: the value of --touch. With `auto`, a storm of delays makes io_node compute forces beside the device.
std::vector<std::string> tight_limits(const std::string& touch);

bool waits_for(System& system, const std::function<bool(const Json&)>& holds);
// True if forces come from patches of the scene.
bool feels_patches(System& system);

// How many probe states were received, and how many of them had a force.
struct Watched {
  int states = 0;
  int forces = 0;
};
// Expects the force to stay within its limits for this long, and then until a state, or a state with a force, has been received.
enum class Until { state, force };
Watched expect_within_limits(SessionObserver& observer, double seconds, Until until = Until::state);

}  // namespace hapton::process
