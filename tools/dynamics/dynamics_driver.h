#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "link/known_moves.h"
#include "link/messages.h"
#include "scene/scene_file.h"
#include "tools/dynamics/dynamics_world.h"

namespace hapton::dynamics {

// Rigid-body dynamics beside a running session, without its machine: the hub's messages go in, requests to move the bodies come out. Time
// of the dynamics is scene time, so that it stands still while the haptics node does.
//
// A pushed body is a loop with a delay t: the hand feels the body where the haptics node has it, later than the dynamics. A spring K with a
// delay gives the body energy like a damping of -K t, so that it bounces off the hand. A pressed body is therefore damped at the contact by
// kDampingShare K t, with K the stiffness of its material and t measured: from each request to its reply, a move and a state more. A hand
// that pushes at a speed v feels that as a resistance of kDampingShare K t v. Threads: one. RT: no.
class DynamicsDriver {
 public:
  // Requests a second, of all bodies together. The haptics node carries out 250.
  static constexpr double kRequestRateHz = 200.0;
  static constexpr double kDampingShare = 1.25;

  struct Settings {
    Vec3 gravity_W = {0.0, -9.81, 0.0};
    double friction = 0.4;
    double damping_share = kDampingShare;
    std::uint32_t first_request = 1;  // the numbers of requests begin here: random in a program, so that no two programs share them
  };

  struct Counts {
    std::uint64_t steps = 0;
    std::uint64_t requests = 0;
    std::uint64_t pushes = 0;      // samples in which a body was pressed
    std::uint64_t fallen = 0;      // bodies put back
    std::int64_t left_out_ns = 0;  // scene time that the bodies stood still, as the states came too slowly
    std::uint64_t restarts = 0;    // of the haptics node
  };

  // Error: as DynamicsWorld::make. Pre: the scene outlives this.
  static Result<DynamicsDriver> make(const Scene& scene, const Settings& settings);

  // A state of the probe, at most one a sample: moves the bodies on to its scene time.
  void take(const ProbeState& state);
  // Gravity follows the view.
  void take(const HapticsSetup& setup);
  // An obstacle that another program moves.
  // arrival: as HubClient::last_arrival of this move.
  void take(const ObjectMove& move, Arrival arrival) { moves_.take(move, arrival); }
  void take(const MoveReply& reply);

  // The next request that is due; nothing: none is. now_ns: any clock.
  std::optional<MoveRequest> next_request(std::int64_t now_ns);

  // The last rejection of a request since the last call; empty: none.
  std::string take_rejection();
  // The bodies that fell out of the scene since the last call, and are back where they began.
  std::vector<int> take_fallen();
  // From a request until it is felt, with the time that the requested move takes.
  double delay_s() const noexcept { return delay_s_; }
  const Counts& counts() const noexcept { return counts_; }
  const DynamicsWorld& world() const noexcept { return *world_; }

 private:
  struct Body {
    int object = -1;
    Keyframe requested;                  // by the newest request
    std::optional<MoveRequest> pending;  // the newest, not replied to yet
    std::int64_t sent_ns = 0;            // ... when it was sent last
    std::int64_t sent_scene_ns = 0;      // ... its scene time
    std::int64_t not_before_ns = 0;      // ... the earliest time of the next, after a rejection
    bool is_known = false;               // the haptics node has had a request and not rejected it
  };

  DynamicsDriver(const Scene& scene, const Settings& settings, std::unique_ptr<DynamicsWorld> world);
  void advance_to(std::int64_t scene_time_ns);
  void move_obstacles(double time_s);
  std::optional<Push> find_push(const ProbeState& state) const;
  bool is_unknown(const Body& body) const;
  bool is_due(const Body& body, std::int64_t now_ns) const;
  MoveRequest make_request(Body& body);

  const Scene* scene_;
  Settings settings_;
  std::unique_ptr<DynamicsWorld> world_;
  std::vector<Body> bodies_;
  KnownMoves moves_;  // of obstacles
  Pose X_WS_ = Pose::Identity();
  std::size_t next_body_ = 0;  // in turn
  std::int64_t next_request_ns_ = 0;
  std::int64_t scene_time_ns_ = -1;  // of the last state
  std::int64_t interval_ns_ = 0;     // ... since the one before
  std::int64_t world_time_ns_ = 0;   // scene time that the bodies have reached
  std::uint32_t last_request_;
  double period_s_;
  double delay_s_;
  std::vector<int> fallen_;
  std::string rejection_;
  Counts counts_;
};

}  // namespace hapton::dynamics
