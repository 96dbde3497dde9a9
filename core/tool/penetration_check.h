#pragma once

#include "core/tool/near_features.h"

namespace hapton {

// Tells whether a placement of the tool is free, by other means than the proxy's: triangles against triangles with exact signs. For tests,
// benches and stress. Units: TouchGeometry's local ones. RT: no (it costs what lies near the tool). Pre: the geometries outlive this; the
// scene is built at once.
class PenetrationCheck {
 public:
  PenetrationCheck(const ObjectGeometry& tool, const TouchGeometry& scene);

  // True if a triangle of the tool intersects one of the scene, or if there are too many near each other to tell.
  bool penetrates(const Placement& at);
  // The distance of tool and scene, if it is at most `distance`; otherwise infinite. 0 if there are too many pairs to tell. Intersecting
  // surfaces have one too: ask penetrates first.
  double find_gap(const Placement& at, double distance);

 private:
  NearPairs pairs_;
  NearFeatures near_;
};

}  // namespace hapton
