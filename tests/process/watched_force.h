#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/process/system.h"

namespace hapton::process {

// Limits that a fault comes near, and as many probe states as samples.
constexpr double kMaxForceN = 1.5;
constexpr double kMaxSlewNPerS = 100.0;
// touch: of io_node --touch. A storm of delays has forces computed beside the device with `auto`.
std::vector<std::string> tight_limits(const std::string& touch);

bool waits_for(System& system, const std::function<bool(const Json&)>& holds);
// Forces come from patches of the scene.
bool feels_patches(System& system);

// Observes the force for this long, and as much longer as nothing, or no force, has been seen: within its limits.
enum class Until { seen, force };
struct Watched {
  int seen = 0;
  int force = 0;
};
Watched expect_bounded(SessionObserver& observer, double seconds, Until until = Until::seen);

}  // namespace hapton::process
