#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/effects/smooth_velocity.h"
#include "link/hub_connection.h"
#include "runtime/realtime.h"
#include "tools/dds/ros_node.h"
#include "tools/dds/servo_force.h"
#include "tools/dds/stamp_clock.h"

namespace hapton::dds {

struct BridgeSettings {
  HubConnection::Settings hub;
  RosNode::Options ros;
  double seconds = 0.0;                   // 0: until stopped
  std::optional<double> accept_forces_n;  // none: no force is taken from DDS
  double accept_torques_nm = 0.0;         // with forces; 0: none
  RealtimeMode realtime = RealtimeMode::attempt;
  std::string haptics_key_file;  // for that; empty: hub.key_file
};

// What a run did.
struct BridgeSummary {
  std::uint64_t samples = 0;  // of the device, published
  std::uint64_t skipped = 0;  // between these, that the hub did not send
  std::uint64_t lost = 0;     // datagrams that the network lost
  PublishCounts published;
  double seconds = 0.0;
  double servo_rate_hz = 0.0;
  std::uint64_t replies = 0;  // with forces from DDS, to the hub
  std::optional<ServoForce::Counts> forces;
};

// What becomes of the hub's probe states: samples for ROS, each once, with velocities and stamps. RT: make yes. Threads: one.
class SampleMaker {
 public:
  explicit SampleMaker(bool has_hub_clock) noexcept : stamps_(has_hub_clock) {}

  // None for a state no newer than the one before. session: the hub's; another one starts again. The other times as in StampClock.
  std::optional<RosSample> make(const ProbeState& probe, std::uint64_t session, std::int64_t received_ns,
                                std::int64_t day_offset_ns) noexcept;
  // Samples of one session between those made.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  StampClock stamps_;
  SmoothVelocity linear_;
  SmoothVelocity angular_;
  std::uint64_t session_ = 0;
  ProbeState last_;
  Vec3 turned_rad_ = Vec3::Zero();  // all rotation vectors so far
  std::uint64_t skipped_ = 0;
};

// Joins the hub as a vision node and publishes what it shows until time is up or is_over says so. say: a line for a person. Error, one
// line: no hub, no DDS, a right that is missing. RT: no. Threads: blocks the caller.
Result<BridgeSummary> run_bridge(const BridgeSettings& settings, const std::function<bool()>& is_over,
                                 const std::function<void(const std::string&)>& say);

// One line. RT: no.
std::string to_text(const BridgeSummary& summary);

}  // namespace hapton::dds
