#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/tool/tool_step.h"
#include "link/known_moves.h"
#include "link/messages.h"
#include "scene/scene_file.h"
#include "tools/dynamics/dynamics_world.h"

namespace hapton::dynamics {

// Rigid-body dynamics beside a running session, without sockets or clocks: messages of the hub go in, requests to move the bodies come out.
// The time of the dynamics is scene time, so that it stops while the haptics node does.
//
// A pushed body is part of a loop with a delay t: the force is computed with the pose that the haptics node has, which is older than that
// of the dynamics. A spring K with this delay acts on the body like a damping of -K t: it adds energy, and the body bounces off the hand. A
// pressed body is therefore damped at the contact by kDampingShare K t, with K the stiffness of its material. t is measured: the time from
// each request to its reply, plus the duration of a move and the interval between two states. A hand that pushes at a speed v feels the
// damping as a resistance of kDampingShare K t v. A rigid tool has one spring and one torsion spring for all bodies; its wrench on a body
// comes separately from that on the hand (ProbeState::push), and the turning of the body is damped likewise. Threads: one. RT: no.
class DynamicsDriver {
 public:
  // The most requests a second, for all bodies together. The hub passes on 250 from one sender (RequestHandler::kMovesPerSecond).
  static constexpr double kRequestRateHz = 200.0;
  static constexpr double kDampingShare = 1.25;  // above 1: the damping takes more energy than the delay adds

  struct Settings {
    Vec3 gravity_W = {0.0, -9.81, 0.0};
    double friction = 0.4;
    double damping_share = kDampingShare;
    std::uint32_t first_request = 1;  // first request number; programs choose it at random, so that no two use the same ones
  };

  struct Counts {
    std::uint64_t steps = 0;
    std::uint64_t requests = 0;
    std::uint64_t pushes = 0;      // states in which a body was pressed
    std::uint64_t fallen = 0;      // bodies that fell out of the scene and were put back
    std::int64_t left_out_ns = 0;  // scene time that was not simulated, because states came too far apart
    std::uint64_t restarts = 0;    // restarts of the haptics node: scene time went back
  };

  // Error: that of DynamicsWorld::make. Pre: the scene outlives this object.
  static Result<DynamicsDriver> make(const Scene& scene, const Settings& settings);

  // Simulates up to the scene time of the state. Pre: at most one call for each sample.
  void take(const ProbeState& state);
  // Takes the view transform, which turns gravity in frame S, and the stiffness of a rigid tool from the description of the method.
  void take(const HapticsSetup& setup);
  // Takes the materials that were changed in the running session.
  void take(const MaterialState& state);
  // Takes the move of an obstacle by another program.
  // arrival: the value of HubClient::last_arrival() for this message.
  void take(const ObjectMove& move, Arrival arrival) { moves_.take(move, arrival); }
  void take(const MoveReply& reply);
  // Takes the state of an obstacle that the stylus has picked up or put down. arrival: as above.
  void take(const ObjectPose& pose, Arrival arrival = Arrival::newest);

  // The next request to send, if one is due. now_ns: any monotonic clock.
  std::optional<MoveRequest> next_request(std::int64_t now_ns);

  // The reason of the last rejected request since the last call; empty: none was rejected.
  std::string take_rejection();
  // The numbers of the objects that since the last call fell out of the scene and were put back where the scene file places them.
  std::vector<int> take_fallen();
  // The delay t of the comment on this class.
  double delay_s() const noexcept { return delay_s_; }
  const Counts& counts() const noexcept { return counts_; }
  const DynamicsWorld& world() const noexcept { return *world_; }

 private:
  struct Body {
    int object = -1;
    Keyframe requested;                  // pose in the newest request
    std::optional<MoveRequest> pending;  // the newest request, while it has no reply
    std::int64_t sent_ns = 0;            // when it was sent last
    std::int64_t sent_scene_ns = 0;      // scene time when it was first sent
    std::int64_t not_before_ns = 0;      // after a rejection: the earliest time of the next request
    bool is_pose_sent = false;           // a request was sent and not rejected
  };

  DynamicsDriver(const Scene& scene, const Settings& settings, std::unique_ptr<DynamicsWorld> world);
  void advance_to(std::int64_t scene_time_ns);
  void move_obstacles(double time_s);
  std::optional<Push> find_push(const ProbeState& state) const;
  Push find_tool_push(const ProbeState& state, const Pose& X_SW) const;
  bool is_pose_outdated(const Body& body) const;
  bool is_due(const Body& body, std::int64_t now_ns) const;
  MoveRequest make_request(Body& body);

  const Scene* scene_;
  Settings settings_;
  std::unique_ptr<DynamicsWorld> world_;
  std::vector<Body> bodies_;
  std::vector<Material> materials_;   // one for each object of the scene
  std::optional<ToolCoupling> tool_;  // coupling of the rigid tool; none: the stylus holds no tool
  KnownMoves moves_;                  // the moves of obstacles
  Pose X_WS_ = Pose::Identity();
  std::size_t next_body_ = 0;  // bodies take turns
  std::int64_t next_request_ns_ = 0;
  std::int64_t scene_time_ns_ = -1;  // scene time of the last state; -1: none yet
  std::int64_t interval_ns_ = 0;     // scene time between the last two states
  std::int64_t world_time_ns_ = 0;   // scene time up to which the bodies were simulated
  std::uint32_t last_request_;       // number of the last request
  double period_s_;                  // time between two requests for one body: the duration of a move
  double delay_s_;
  std::vector<int> fallen_;
  std::string rejection_;
  Counts counts_;
};

}  // namespace hapton::dynamics
