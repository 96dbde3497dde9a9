#include "core/effects/tissue_layers.h"

#include <algorithm>

namespace hapton {

double TissueLayers::spring_force(double depth_m, const State& state) const noexcept {
  if (state.punctured_count == count_) return 0.0;
  return layers_[state.punctured_count].stiffness_n_per_m * std::max(0.0, depth_m - state.rest_depth_m);
}

double TissueLayers::force(double depth_m, double inward_m_per_s, State& state) const noexcept {
  if (count_ == 0) return 0.0;
  if (!state.has_begun) state = {.punctured_count = 0, .rest_depth_m = layers_[0].depth_m, .has_begun = true};
  double spring_n = spring_force(depth_m, state);
  while (state.punctured_count < count_ && spring_n > layers_[state.punctured_count].pop_force_n) {
    ++state.punctured_count;
    if (state.punctured_count < count_) state.rest_depth_m = std::max(depth_m, layers_[state.punctured_count].depth_m);
    spring_n = spring_force(depth_m, state);
  }
  const double drag_n = state.punctured_count > 0 ? layers_[state.punctured_count - 1].drag_ns_per_m * inward_m_per_s : 0.0;
  return std::clamp(spring_n + drag_n, -kMaxEffectForceN, kMaxEffectForceN);
}

}  // namespace hapton
