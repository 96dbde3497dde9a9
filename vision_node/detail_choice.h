#pragma once

#include <cstddef>
#include <span>

namespace hapton {

// What the choice of a level goes by.
struct LevelFacts {
  std::size_t triangles = 0;
  double error_m = 0.0;  // how far the level lies from the mesh
};

// A level is as good as the mesh where it lies within this of it: no edge of the picture moves by as much as its smoothing would.
inline constexpr double kUnseenErrorPx = 0.2;

// Which level to draw while the scene moves: the one with the fewest triangles among those whose error is not seen; where that has more
// triangles than the budget, the finest within the budget; where none is, the coarsest. Pre: levels from the finest, which is the mesh
// itself, to the coarsest; at least one. RT: no.
std::size_t choose_level(std::span<const LevelFacts> levels, double pixels_per_m, std::size_t budget);

}  // namespace hapton
