#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace hapton {

using Segment2 = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

// The diameter of the largest disc within closed polygons, given by all their edges in any order; an area within two of them is outside.
// Never too small; too large by up to 1 %, or by more where that would take longer than about 0.1 s. Where it is not above `enough`: any
// bound of it up to `enough`. Not finite or no area: 0.
//
// A search that halves squares, the most promising first: a square's middle has a distance from the edges, and no point of the square has
// a larger one than that and half of its diagonal (Garcia-Castellanos & Lombardo 2007 search alike). Unit: that of the edges. Time: that
// 0.1 s, or a few passes over the edges. RT: set-up only.
double largest_disc(std::vector<Segment2> edges, double enough = 0.0);

}  // namespace hapton
