#pragma once

#include <cstdint>

#include "core/math/types.h"
#include "link/fault_injector.h"
#include "remote_touch/network_path.h"

namespace hapton {

// The network between the device and the node that knows the scene.
struct RemoteNetwork {
  LinkFaults up = {};    // samples, from the device
  LinkFaults down = {};  // replies
  std::uint64_t seed = 1;

  // Half of the round trip each way, loss each way.
  static RemoteNetwork of(double round_trip_s, double loss, double jitter_s, std::uint64_t seed);
};

// What was sent so far.
struct RemoteTraffic {
  Traffic up;
  Traffic down;   // parts of the scene among them
  Traffic scene;  // these alone

  RemoteTraffic operator+(const RemoteTraffic& more) const noexcept { return {up + more.up, down + more.down, scene + more.scene}; }
  RemoteTraffic operator-(const RemoteTraffic& before) const noexcept { return {up - before.up, down - before.down, scene - before.scene}; }
};

// The force to write, and the sample that it replies to.
struct RemoteStep {
  Vec3 force_n = Vec3::Zero();
  std::int64_t sample_ns = 0;
};

// A method of touch across a network: both ends and the network between them, in simulated time. The force of a step is written at once and
// held until the next step; datagrams are received at steps only. Frames: W and S are one. Units: SI, ns. RT: no. Threads: one.
class RemoteTouch {
 public:
  virtual ~RemoteTouch() = default;
  // A sample of the device. Pre: now_ns increases by one period of the device.
  virtual RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) = 0;
  // Everything that it needs near the device has arrived.
  virtual bool is_ready() const { return true; }
  virtual RemoteTraffic traffic() const = 0;
};

}  // namespace hapton
