#pragma once

#include "core/tool/feature_pair.h"

namespace hapton {

// A lower bound of the time of impact of a pair: until then it certainly stays at least `floor` apart over the motion; `until` if that is
// earlier. Each advance is a part of the motion, by a bound of second order (conservative advancement, Mirtich 1996; we differ in bounding
// a vertex against a triangle in the triangle's frame, where the distance is a convex function of the point, and edge pairs by the triple
// product w . (d x e)), and after kMaxAdvances of them the time reached is returned. Edges that are parallel to within floor / 4 over their
// length may come to 3/4 of the floor: their ends, pairs of a vertex and a face, keep the floor. RT: yes. Pre: gap is the pair's at
// motion.from; floor > 0.
double bound_time_of_impact(const FeaturePair& pair, const FeatureGap& gap, const RigidMotion& motion, double floor, double until) noexcept;

constexpr int kMaxAdvances = 32;  // over a motion; a choice that bounds the work of a pair

}  // namespace hapton
