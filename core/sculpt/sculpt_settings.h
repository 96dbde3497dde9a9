#pragma once

#include <cstdint>

namespace hapton {

// How an object is carved. Units: m.
struct SculptSettings {
  // Defaults of a scene file: voxels along the object's longest side, and voxels in the tool's radius.
  static constexpr double kVoxelsOfSide = 128.0;
  static constexpr double kVoxelsOfRadius = 5.0;
  // The smallest tool radius, in voxels: a smaller ball could pass between the nodes of the field.
  static constexpr double kMinVoxelsOfRadius = 2.0;

  double voxel_m = 0.0;        // spacing of the field's nodes
  double tool_radius_m = 0.0;  // radius of the ball that carves the material and touches it
  std::uint32_t button = 1;    // bit of the stylus' button (button_bit): the ball carves while it is down

  bool operator==(const SculptSettings&) const = default;
};

}  // namespace hapton
