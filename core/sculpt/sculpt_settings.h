#pragma once

#include <cstdint>

namespace hapton {

// How an object of material is carved. Units: m.
struct SculptSettings {
  // Of the object's longest side, where a scene file gives no voxel, and of the tool's radius in voxels, where it gives no radius.
  static constexpr double kVoxelsOfSide = 128.0;
  static constexpr double kVoxelsOfRadius = 5.0;
  // A ball smaller than this many voxels would leave a hole between two nodes of the field.
  static constexpr double kLeastVoxelsOfRadius = 2.0;

  double voxel_m = 0.0;        // spacing of the field's nodes
  double tool_radius_m = 0.0;  // of the ball that carves, and that touches the material
  std::uint32_t button = 1;    // of the stylus: carves while it is down; a bit (button_bit)

  bool operator==(const SculptSettings&) const = default;
};

}  // namespace hapton
