#pragma once

#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <thread>

#include "core/base/result.h"
#include "link/hub_connection.h"
#include "runtime/realtime.h"
#include "tools/dds/ros_node.h"
#include "tools/dds/servo_force.h"

namespace hapton::dds {

// A haptics node whose forces come from the topic servo_cf: it replies to each sample of the device with the force in effect then, or with
// zero. It takes the hub's only place for a haptics node, and the governor of io_node limits its forces. RT: no. Threads: it has a thread
// of its own; its functions are called from one other thread.
class ForceReplier {
 public:
  struct Settings {
    HubConnection::Settings hub;
    double most_n = 0.0;   // larger forces are scaled down
    double most_nm = 0.0;  // the same for torques; 0: none are allowed
    std::string frame;     // the name of frame W in messages: forces in another frame are dropped
    RealtimeMode realtime = RealtimeMode::attempt;
  };
  // Error, one line: no hub, no right to join, the hub already has a haptics node, or real time is required and denied. Pre: node was
  // opened with takes_forces and outlives this.
  static Result<std::unique_ptr<ForceReplier>> start(RosNode& node, const Settings& settings);
  ~ForceReplier();
  ForceReplier(const ForceReplier&) = delete;
  ForceReplier& operator=(const ForceReplier&) = delete;

  // What the system has granted to the thread that computes forces.
  const RealtimeReport& realtime() const noexcept { return realtime_; }
  // Ends the thread and leaves the hub, which then releases the force.
  void stop();
  // Pre, for both: stop() was called.
  const ServoForce::Counts& counts() const noexcept { return force_.counts(); }
  std::uint64_t replies() const noexcept { return replies_; }
  // The newest verdict other than `accepted` (reduced or dropped) since the last call, for a line in the log.
  std::optional<ServoForce::Verdict> take_warning() noexcept;

 private:
  ForceReplier(RosNode& node, const Settings& settings, std::unique_ptr<HubConnection> connection);
  void run(RealtimeMode realtime);
  void take_commands();
  void reply(const DeviceState& state, std::uint32_t states);  // states: received since the last reply

  RosNode& node_;
  std::unique_ptr<HubConnection> connection_;
  ServoForce force_;
  ForceCommand command_;
  std::uint64_t replies_ = 0;
  std::promise<Result<RealtimeReport>> rights_;  // of the thread, once it has begun
  RealtimeReport realtime_;
  std::atomic<int> warning_{-1};
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace hapton::dds
