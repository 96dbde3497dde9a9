#pragma once

#include <cstddef>
#include <span>

namespace hapton {

// What the choice of a level of detail depends on.
struct LevelFacts {
  std::size_t triangles = 0;
  double error_m = 0.0;  // largest distance of the level from the mesh
};

// A level within this distance of the mesh, in pixels, looks like the mesh: no edge moves by more than anti-aliasing blurs it.
inline constexpr double kUnseenErrorPx = 0.2;

// The level to draw while the scene moves: the one with the fewest triangles among those whose error is invisible; if that has more
// triangles than the budget, the next coarser one within the budget; if there is none, the coarsest. Pre: levels from the finest, which is
// the mesh itself, to the coarsest; at least one. RT: no.
std::size_t choose_level(std::span<const LevelFacts> levels, double pixels_per_m, std::size_t budget);

}  // namespace hapton
