#include "core/tool/penetration_check.h"

#include <algorithm>
#include <limits>

#include "core/collision/triangle_pair.h"

namespace hapton {

PenetrationCheck::PenetrationCheck(const ObjectGeometry& tool, const TouchGeometry& scene)
    : tool_(&tool), scene_(&scene), pairs_(tool, scene, NearFeatures::kMostTrianglePairs), near_(tool, scene) {}

bool PenetrationCheck::penetrates(const Placement& at) {
  if (!pairs_.collect(at, 0.0, NearFeatures::kMostTrianglePairs)) return true;
  return std::any_of(pairs_.pairs().begin(), pairs_.pairs().end(), [&](const TrianglePairIds& ids) {
    const ObjectGeometry::Corners a = tool_->corners(ids.tool);
    const ObjectGeometry::Corners b = scene_->corners(ids.scene);
    return intersect_triangles({{at.at(a.a), at.at(a.b), at.at(a.c)}, {b.a, b.b, b.c}}).meets;
  });
}

double PenetrationCheck::find_gap(const Placement& at, double distance) {
  if (!near_.collect(at, distance, 0.0)) return 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (const NearFeature& near : near_.features()) least = std::min(least, near.gap.distance);
  return least;
}

}  // namespace hapton
