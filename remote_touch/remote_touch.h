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

  // The same in both directions: half of the round trip as delay, with this loss and jitter.
  static RemoteNetwork of(double round_trip_s, double loss, double jitter_s, std::uint64_t seed);
};

// What has been sent so far.
struct RemoteTraffic {
  Traffic up;
  Traffic down;   // replies and parts of the scene
  Traffic scene;  // the parts of the scene alone

  RemoteTraffic operator+(const RemoteTraffic& more) const noexcept { return {up + more.up, down + more.down, scene + more.scene}; }
  RemoteTraffic operator-(const RemoteTraffic& before) const noexcept { return {up - before.up, down - before.down, scene - before.scene}; }
};

// The force to write, and the time of the sample that it replies to.
struct RemoteStep {
  Vec3 force_n = Vec3::Zero();
  std::int64_t sample_ns = 0;
};

// A method of touch across a network: both ends and the network between them, in simulated time. The force of a step is written at once and
// held until the next step; datagrams are received at steps only. Frames: W and S are one. Units: SI, ns. RT: no. Threads: one.
class RemoteTouch {
 public:
  virtual ~RemoteTouch() = default;
  // Takes a sample of the device. Pre: now_ns increases by a period of the device, or by several after a stall.
  virtual RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) = 0;
  // True: everything that the method needs near the device has arrived.
  virtual bool is_ready() const { return true; }
  virtual RemoteTraffic traffic() const = 0;
};

}  // namespace hapton
