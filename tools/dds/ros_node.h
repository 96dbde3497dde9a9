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

// One sample of the device as ROS 2 sees it. Frame W; angular velocity is that of the stylus.
struct RosSample {
  ProbeState probe;
  Vec3 linear_m_per_s = Vec3::Zero();
  Vec3 angular_rad_per_s = Vec3::Zero();
  std::int64_t stamp_ns = 0;  // time of day, since 1970
};

struct PublishCounts {
  std::uint64_t written = 0;  // messages of all topics
  std::uint64_t failed = 0;   // that the engine did not take
};

// A participant of a DDS domain with the topics of docs/dds.md, by Cyclone DDS. RT: no. Threads: publish and note_buttons one, take_forces
// one other.
class RosNode {
 public:
  struct Options {
    int domain = 0;
    std::string interface = {};      // name or address; "auto": DDS chooses; empty: what CYCLONEDDS_URI says, and without that this host
    std::string prefix = "/hapton";  // of make_prefix
    std::string frame = "world";     // frame W
    bool is_reliable = false;        // best effort otherwise, as ROS 2 sends sensor data
    double tf_rate_hz = 100.0;       // most transforms a second; 0: none
    bool takes_forces = false;       // with a reader of PREFIX/servo_cf
  };

  // Error, one line: built without DDS, no such network interface, or what the engine says. Pre: names are checked.
  static Result<std::unique_ptr<RosNode>> open(const Options& options);
  ~RosNode();
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;

  // Pre: stamps increase.
  void publish(const RosSample& sample);
  const PublishCounts& counts() const noexcept;

  // Hands what has come on servo_cf since the last call to visit, oldest first, some at most. Pre: takes_forces.
  void take_forces(const std::function<void(const ServoCommand&)>& visit);

 private:
  struct State;
  explicit RosNode(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton::dds
