#include "core/tool/penetration_check.h"

#include <algorithm>
#include <limits>

namespace hapton {

double PenetrationCheck::find_gap(const Placement& at, double distance) {
  // A search that was aborted restarts at the roots of the trees the next time, and may then need fewer tests.
  if (!near_.collect(at, distance, 0.0) && !near_.collect(at, distance, 0.0)) return 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (const NearFeature& near : near_.features()) least = std::min(least, near.gap.distance);
  return least;
}

}  // namespace hapton
