#include "vision_node/detail_choice.h"

namespace hapton {

std::size_t choose_level(std::span<const LevelFacts> levels, double pixels_per_m, std::size_t budget) {
  std::size_t coarsest_unseen = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (levels[i].error_m * pixels_per_m <= kUnseenErrorPx) coarsest_unseen = i;
  }
  std::size_t chosen = coarsest_unseen;
  while (chosen + 1 < levels.size() && levels[chosen].triangles > budget) ++chosen;
  return chosen;
}

}  // namespace hapton
