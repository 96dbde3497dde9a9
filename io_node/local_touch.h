#pragma once

#include <cstdint>
#include <optional>

#include "core/math/types.h"
#include "devices/device.h"

namespace hapton {

// The force for one sample, computed in the device's own thread. Frame W (world).
struct LocalForce {
  Vec3 force_n = Vec3::Zero();
  Vec3 visual_offset_m = Vec3::Zero();  // proxy minus device point
  bool contact = false;
  bool is_handed_over = false;       // by another patch than for the sample before: the difference of force fades
  Vec3 difference_n = Vec3::Zero();  // ... or just this difference, where it is known for this sample
  int object = -1;                   // the touched object, by its number in the scene; -1: none
  std::int64_t scene_time_ns = -1;   // scene time of the sample, in a scene that moves; below 0: nothing moves
  // Proxy minus device point, where the probe is drawn elsewhere (ForceCommand). None: visual_offset_m.
  std::optional<Vec3> held_offset_m = {};
};

// Computes forces in the device's own thread, for the device loop. While it does, forces from the network are not used.
// Frames: W. Units: SI. RT: yes.
class LocalTouch {
 public:
  virtual ~LocalTouch() = default;
  // None: the force has to come from the network.
  virtual std::optional<LocalForce> step(const DeviceSample& sample) noexcept = 0;
};

}  // namespace hapton
