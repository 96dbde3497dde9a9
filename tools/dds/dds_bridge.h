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
  std::optional<double> accept_forces_n;  // largest force taken from DDS; none: no forces are taken
  double accept_torques_nm = 0.0;         // largest torque taken from DDS, only with accept_forces_n; 0: none
  RealtimeMode realtime = RealtimeMode::attempt;
  std::string haptics_key_file;  // for joining as a haptics node, if forces are taken; empty: hub.key_file
};

// The counts of one run of the bridge.
struct BridgeSummary {
  std::uint64_t samples = 0;  // published samples of the device
  std::uint64_t skipped = 0;  // samples between these that did not come: not sent by the hub, or lost
  std::uint64_t lost = 0;     // datagrams that the network lost
  PublishCounts published;
  double seconds = 0.0;
  double servo_rate_hz = 0.0;
  std::uint64_t replies = 0;  // replies sent to the hub, if forces are taken
  std::optional<ServoForce::Counts> forces;
};

// Makes samples for ROS from the hub's probe states: each state once, with velocities and a stamp. RT: make yes. Threads: one.
class SampleMaker {
 public:
  explicit SampleMaker(bool has_hub_clock) noexcept : stamp_clock_(has_hub_clock) {}

  // None for a state that is not newer than the last one. session: the hub's; a new one resets all but skipped(). Times: see StampClock.
  std::optional<RosSample> make(const ProbeState& probe, std::uint64_t session, std::int64_t received_ns,
                                std::int64_t day_offset_ns) noexcept;
  // The number of samples that are missing between the states that came, in all sessions.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  StampClock stamp_clock_;
  SmoothVelocity linear_velocity_;
  SmoothVelocity angular_velocity_;
  std::uint64_t session_ = 0;
  ProbeState last_probe_;
  Vec3 rotation_sum_rad_ = Vec3::Zero();  // all rotation vectors so far
  std::uint64_t skipped_ = 0;
};

// Joins the hub as a vision node and publishes its samples until time is up or is_over() is true; with accept_forces_n also as a haptics
// node. print_line: gets lines for a person. Error, one line: no hub, no DDS, a right is missing. RT: no. Threads: blocks the caller.
Result<BridgeSummary> run_bridge(const BridgeSettings& settings, const std::function<bool()>& is_over,
                                 const std::function<void(const std::string&)>& print_line);

// The summary as one line for a person. RT: no.
std::string to_text(const BridgeSummary& summary);

}  // namespace hapton::dds
