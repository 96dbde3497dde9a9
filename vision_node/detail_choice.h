#pragma once

#include <cstddef>
#include <span>

namespace hapton {

// Inputs of the choice of a level.
struct LevelFacts {
  std::size_t triangles = 0;
  double error_m = 0.0;  // how far the level lies from the mesh
};

// A level within this distance of the mesh is as good as the mesh: no edge of the picture moves by more than its anti-aliasing.
inline constexpr double kUnseenErrorPx = 0.2;

// The level to draw while the scene moves: the one with the fewest triangles among those whose error is invisible; if that has more
// triangles than the budget, the finest within the budget; if there is none, the coarsest. Pre: levels from the finest, which is the mesh
// itself, to the coarsest; at least one. RT: no.
std::size_t choose_level(std::span<const LevelFacts> levels, double pixels_per_m, std::size_t budget);

}  // namespace hapton
