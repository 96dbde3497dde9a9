#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace hapton {

using Segment2 = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

// The diameter of the largest disc within closed polygons, given by all their edges in any order; an area within two of them counts as
// outside. Never too small; too large by up to 1 %, or by more where that accuracy would take longer than about 0.1 s. If the diameter is
// not above `negligible_diameter`, the result may be any upper bound up to `negligible_diameter`. No edges, or one that is not finite: 0.
// No area: near 0.
//
// The search divides squares into four, the most promising first: no point of a square is farther from the edges than its centre is, plus
// half of its diagonal (Garcia-Castellanos & Lombardo 2007 search in the same way). Unit: that of the edges. Time: up to those 0.1 s, or a
// few passes over the edges if these take longer. RT: set-up only.
double largest_disc(std::vector<Segment2> edges, double negligible_diameter = 0.0);

}  // namespace hapton
