#include "scene/scene_key.h"

namespace hapton {

std::string_view scene_key_of(StiffCause cause) noexcept {
  switch (cause) {
    case StiffCause::none:
    case StiffCause::spring:
    case StiffCause::spring_effect:
      return "its stiffness_n_per_m";
    case StiffCause::stiffness_map:
      return "its stiffness_map_n_per_m";
    case StiffCause::progressive:
      return "its stiffness_n_per_m, with what progressive_n_per_m2 adds at 10 N,";
    case StiffCause::layers:
      return "the stiffness_n_per_m of its layers";
    case StiffCause::surface_snap:
      return "its snap_stiffness_n_per_m";
    case StiffCause::bumps:
      return "its bump_height_m (of a normal map: normal_map_scale)";
    case StiffCause::snap_effect:
      return "4 max_force_n / range_m";
    case StiffCause::gravity_well:
      return "1.84 max_force_n / radius_m";
  }
  return "";
}

}  // namespace hapton
