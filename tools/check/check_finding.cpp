#include "tools/check/check_finding.h"

namespace hapton {

std::string_view name_of(SceneFault fault) noexcept {
  switch (fault) {
    case SceneFault::thin_wall:
      return "thin-wall";
    case SceneFault::opening:
      return "opening";
    case SceneFault::crack:
      return "crack";
    case SceneFault::large_fan:
      return "large-fan";
    case SceneFault::flipped:
      return "flipped";
    case SceneFault::inside_out:
      return "inside-out";
    case SceneFault::coincides:
      return "coincides";
    case SceneFault::enclosed:
      return "enclosed";
    case SceneFault::view_inside:
      return "view-inside";
    case SceneFault::rough:
      return "rough";
    case SceneFault::coarse_voxels:
      return "coarse-voxels";
    case SceneFault::no_inertia:
      return "no-inertia";
    case SceneFault::odd_tool:
      return "odd-tool";
    case SceneFault::shape_alone:
      return "shape-alone";
    case SceneFault::overlaps:
      return "overlaps";
    case SceneFault::softer_than_device:
      return "softer-than-device";
    case SceneFault::stiffer_than_device:
      return "stiffer-than-device";
    case SceneFault::stiffer_than_loop:
      return "stiffer-than-loop";
    case SceneFault::tool_stiffer_than_loop:
      return "tool-stiffer-than-loop";
    case SceneFault::more_damped_than_loop:
      return "more-damped-than-loop";
    case SceneFault::heavier_than_loop:
      return "heavier-than-loop";
    case SceneFault::stronger_than_device:
      return "stronger-than-device";
    case SceneFault::faster_than_loop:
      return "faster-than-loop";
    case SceneFault::out_of_reach:
      return "out-of-reach";
    case SceneFault::too_small:
      return "too-small";
    case SceneFault::too_slow:
      return "too-slow";
  }
  return "";
}

}  // namespace hapton
