#pragma once

#include "core/tool/feature_pair.h"

namespace hapton {

// A lower bound of the time of impact of a pair, as a share of the motion, at most `until`: up to that time the pair certainly stays at
// least `floor` apart. Found in advances, each by a second-order bound (conservative advancement, Mirtich 1996; we differ: a vertex and a
// triangle are bounded in the triangle's frame, where the distance is a convex function of the point, and a pair of edges by the triple
// product w . (d x e)); after kMaxAdvances advances the time reached is returned. Exception: edges that are parallel to within floor / 4
// over their length may come as near as 3/4 of the floor: only their ends, which are pairs of a vertex and a face, keep the floor. RT: yes.
// Pre: gap is the pair's at motion.from; floor > 0.
double bound_time_of_impact(const FeaturePair& pair, const FeatureGap& gap, const RigidMotion& motion, double floor, double until) noexcept;

constexpr int kMaxAdvances = 32;  // in a motion; an arbitrary limit of the work for a pair

}  // namespace hapton
