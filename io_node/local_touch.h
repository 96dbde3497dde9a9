#pragma once

#include <cstdint>
#include <optional>

#include "core/math/types.h"
#include "devices/device.h"

namespace hapton {

// The result of one sample, computed beside the device.
struct LocalForce {
  Vec3 force_n = Vec3::Zero();
  Vec3 visual_offset_m = Vec3::Zero();  // proxy minus device point
  bool contact = false;
  bool is_handed_over = false;       // by another patch than the sample before: the difference of force fades
  Vec3 difference_n = Vec3::Zero();  // ... or where that is known for this sample, just this
  int object = -1;                   // touched, of the scene's objects; -1: none
  std::int64_t scene_time_ns = -1;   // of the sample, in a scene that moves; below 0: nothing moves
  // Proxy minus device point, where the probe is drawn elsewhere (ForceCommand). None: visual_offset_m.
  std::optional<Vec3> held_offset_m = {};
};

// Works out forces on the device's own thread, for the device loop. While it does, forces from the network are not used.
// Frames: W. Units: SI. RT: yes.
class LocalTouch {
 public:
  virtual ~LocalTouch() = default;
  // None: the force has to come from elsewhere.
  virtual std::optional<LocalForce> step(const DeviceSample& sample) noexcept = 0;
};

}  // namespace hapton
