#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/math/types.h"
#include "link/messages.h"
#include "tools/dds/servo_force.h"

namespace hapton::dds {

// One sample of the device, as it is published for ROS 2. Frame W; velocities of the device point and of the stylus.
struct RosSample {
  ProbeState probe;
  Vec3 linear_m_per_s = Vec3::Zero();
  Vec3 angular_rad_per_s = Vec3::Zero();
  std::int64_t stamp_ns = 0;  // time of day, since 1970
};

struct PublishCounts {
  std::uint64_t written = 0;  // messages of all topics that Cyclone DDS took
  std::uint64_t failed = 0;   // messages that it did not take
};

// A participant of a DDS domain with the topics of docs/dds.md, named as in CRTK: cf Cartesian force, cp pose, cv velocity. It uses Cyclone
// DDS. RT: no. Threads: publish and counts from one thread,
// take_forces from the same or one other.
class RosNode {
 public:
  struct Options {
    int domain = 0;
    std::string interface = {};      // name or address; "auto": DDS chooses; empty: as CYCLONEDDS_URI says or, unset, this host only
    std::string prefix = "/hapton";  // prefix of the topics, as make_prefix returns it
    std::string frame = "world";     // the name of frame W in messages
    bool is_reliable = false;        // false: best effort, as ROS 2 sends sensor data
    double tf_rate_hz = 100.0;       // the most messages on /tf in a second; 0: none
    bool takes_forces = false;       // reads the topic PREFIX/servo_cf, commanded Cartesian forces
  };

  // Error, one line: built without DDS, no such network interface, or Cyclone DDS fails. Pre: the names were checked (ros_names.h).
  static Result<std::unique_ptr<RosNode>> open(const Options& options);
  ~RosNode();
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;

  // Pre: stamps increase, except where the time of day was set back (StampClock).
  void publish(const RosSample& sample);
  const PublishCounts& counts() const noexcept;

  // Calls visit for the commands that came on servo_cf since the last call, oldest first, at most the newest 16. Pre: takes_forces.
  void take_forces(const std::function<void(const ServoCommand&)>& visit);

 private:
  struct State;
  explicit RosNode(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton::dds
