#pragma once

#include "core/tool/near_features.h"

namespace hapton {

// Tells whether a placement of the tool is free of intersections, independently of the proxy: tests triangles against triangles with exact
// predicates. For tests, benches and `hapton stress`. Frame and units: TouchGeometry's local ones. RT: no (the time depends on the number
// of triangles near the tool). Pre: the geometries outlive this; the scene is built at once (BuildPolicy::at_once).
class PenetrationCheck {
 public:
  PenetrationCheck(const ObjectGeometry& tool, const TouchGeometry& scene) : near_(tool, scene) {}

  // True if a triangle of the tool intersects one of the scene, or if too many pairs are near each other to be tested.
  bool penetrates(const Placement& at) { return near_.any_intersect(at); }
  // The distance between tool and scene, if it is at most `distance`; otherwise infinity. 0 if too many pairs of features are within
  // `distance`. Not meaningful while the surfaces intersect: call penetrates() first.
  double find_gap(const Placement& at, double distance);

 private:
  NearFeatures near_;
};

}  // namespace hapton
