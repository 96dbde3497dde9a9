#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "core/collision/neighbourhood.h"
#include "core/collision/swept_sphere.h"
#include "core/force/contact_qp.h"
#include "core/force/force_method.h"
#include "core/force/proxy/surface_follower.h"
#include "core/force/sphere/sphere_follower.h"

namespace hapton {

class FacetDescent;

// What the proxy did since the last reset of the counters. Steps unless named.
struct ProxyCounters {
  std::uint64_t steps = 0;
  std::uint64_t skipped = 0;  // free-space steps settled by the empty ball alone
  std::uint64_t contact_steps = 0;
  std::uint64_t iterations = 0;   // constrained motions in contact steps
  std::uint64_t sweeps = 0;       // continuous collision queries
  std::uint64_t refills = 0;      // neighbourhoods copied,
  std::uint64_t foreseen = 0;     // of them looked up before they were needed
  std::uint64_t tests = 0;        // triangle against moving sphere
  std::uint64_t redone = 0;       // steps done again in parts,
  std::uint64_t divided = 0;      // and in many
  std::uint64_t walks = 0;        // minima found from facet to facet, without a sweep
  double shading_squared = 0.0;   // sum over contact steps of (|shaded - unshaded| / |unshaded|)^2
  double shading_most = 0.0;      // and its largest
  std::uint64_t escapes = 0;      // rests left that are none to a point
  std::uint64_t attempts = 0;     // and how often that was tried
  std::uint64_t flights = 0;      // through the air
  std::uint64_t careful = 0;      // steps, or the rest of one, that sweeps did
  std::uint64_t exhausted = 0;    // steps out of events, carried into the next
  std::uint64_t most_events = 0;  // in one step
  std::uint64_t slips = 0;        // pieces of a sphere's way under friction with the device held
  std::uint64_t unconverged = 0;  // stopped by the iteration bound: a valid proxy, short of the minimum
};

// The god-object (point probe) and sphere probe done to convergence: in every step the proxy moves, never crossing a surface, to
// the constrained local minimum of its distance to the device (Zilles & Salisbury 1995, Ruspini et al. 1997; we differ in
// continuous motion against the triangles themselves, exact active sets, and iteration to convergence within the step).
//
// A point probe is a sphere of radius hover = 2^-30 of the scene's size. Distances decide, never signs of volumes: the proxy's
// distance to every triangle stays above hover / 2 along its whole way, so edges, vertices and cracks narrower than hover are as
// tight as faces, and both sides of a sheet are the same.
//
// Optional force shading (Morgenbesser & Srinivasan 1996) turns the force towards interpolated smooth normals without changing its
// magnitude or the proxy; how far it turned is reported.
//
// Force = stiffness * (proxy - device), less damping * normal velocity; Coulomb friction holds the proxy back inside its cone.
// Frame: S. RT: step and reset yes.
class ProxyMethod final : public ForceMethod {
 public:
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  bool prepare() override;
  std::string describe() const override;

  const ProxyCounters& counters() const { return counters_; }
  const TouchGeometry& geometry() const { return geometry_; }
  const Clearance& clearance() const { return clearance_; }

 private:
  static constexpr int kMaxTouching = 32;
  static constexpr int kMaxExits = 64;
  static constexpr double kBeside = 512.0;  // hovers: an edge or corner as near as this has a say
  static constexpr int kMaxEscapes = 8;     // in a step
  static constexpr int kMaxIterations = 256;
  static constexpr int kMaxSweeps = 4096;           // in a step, whatever it meets: then it ends where it is and goes on in the next
  static constexpr int kEscapeSweeps = 64;          // that an escape may take
  static constexpr double kLookAheadSteps = 500.0;  // an object is asked for half a second before the probe can be there, at 1 kHz
  static constexpr double kLargestReach = 2.0;      // local units: the scene's size
  static constexpr double kLongestMotion = 4.0;     // local units: twice the scene's size
  static constexpr int kMaxIdle = 6;
  static constexpr double kCatchUp = 1.3;       // strides
  static constexpr double kCatchUpFold = 1.01;  // where folds hold the proxy
  static constexpr double kLeap = 1.5;          // strides
  static constexpr double kLetGo = 4.0;         // of a part's own strides: no slide is as fast
  static constexpr int kParts = 8;
  static constexpr double kSamePlace = 0x1p-16;  // strides
  static constexpr int kNearPieces = 4;
  static constexpr double kAround = 0.25;    // of the way: how far beside it the neighbourhood reaches at least
  static constexpr double kAhead = 0.8;      // of the neighbourhood's reach: its centre lies as far ahead
  static constexpr double kForesight = 3.5;  // steps: who leaves it sooner is prepared for the next
  static constexpr int kFewNear = 32;        // a neighbourhood of fewer triangles is grown next time,
  static constexpr int kManyNear = 64;       // one of more is shrunk

  struct Touch {
    std::uint32_t triangle = 0;
    std::uint32_t place = Neighbourhood::kNowhere;  // in the neighbourhood, when last seen there
    ContactTriangle shape;
    Separation separation;
  };
  // How the proxy stands: what a try that leads nowhere is undone to.
  struct Stand {
    Vec3 proxy = Vec3::Zero();
    bool free = true;
    bool sliding = false;
    std::array<std::uint32_t, kMaxTouching> triangles;
    std::array<Separation, kMaxTouching> separations;
    int touching_count = 0;
    std::array<double, 3> push = {0, 0, 0};
    int pushing_count = 0;
  };
  // A way that may lead out of a corner: along one of its edges.
  struct Exit {
    Vec3 direction = Vec3::Zero();  // unit
    bool closed = false;            // leads nowhere from here
  };
  struct Blocker {
    std::uint32_t triangle = 0;
    double time = 0.0;
  };

  ProxyMethod(const MethodSettings& settings, const TouchScene& scene);

  std::string describe_steps() const;

  [[gnu::noinline]] MethodOutput step_outside(const MethodInput& input) noexcept;
  void bring_pushing_first(const ConstrainedMotion& held) noexcept;
  Vec3 shaded(const Vec3& stretch) noexcept;
  Vec3 force_of(const Vec3& stretch_m, const Vec3& velocity_m_per_s) const noexcept;
  bool fold_had_a_say() const noexcept;
  bool has_caught_up() const noexcept;
  bool has_left_fold() const noexcept;
  enum class Doubt : std::uint8_t { none, slight, great };
  Doubt doubt_of_step() const noexcept;
  void follow(const Vec3& last, const Vec3& device) noexcept;
  void follow_by_sweeps(const Vec3& last, const Vec3& device) noexcept;
  bool follow_surface(const Vec3& last, const Vec3& device, double& time) noexcept;
  bool follow_offset(const Vec3& last, const Vec3& device, double& time) noexcept;
  void stand_at_sphere(const Vec3& device) noexcept;
  enum class Met : std::uint8_t { nothing, walkable, other };
  Met fly(const Vec3& from, const Vec3& to, bool slides, double& time) noexcept;
  bool is_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, const Vec3& hit) noexcept;
  bool is_vertex_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, int k, const Vec3& hit) noexcept;
  void clear_start() noexcept;
  void lift_off_surface() noexcept;
  bool stand_on_surface() noexcept;
  void hold_by_surface(const Vec3& device) noexcept;
  void follow_in_parts(const Vec3& last, const Vec3& device, int parts) noexcept;
  void solve(const Vec3& device) noexcept;
  bool walk(const Vec3& device) noexcept;
  FacetDescent facets() noexcept;
  bool is_open_to(const FacetDescent& way) const noexcept;
  void descend(const Vec3& device) noexcept;
  static Vec3 shortened(const Vec3& motion) noexcept;
  ContactTriangle shape_of(std::uint32_t triangle) const noexcept;
  void save(Stand& stand) const noexcept;
  void restore(const Stand& stand) noexcept;
  bool escape(const Vec3& device) noexcept;
  bool tip_over(const Vec3& device) noexcept;
  bool tip(const Vec3& device, const Vec3& sideways) noexcept;
  bool is_in_corner() const noexcept;
  void find_exits() noexcept;
  bool leave_corner(const Vec3& device) noexcept;
  bool is_jammed(const Vec3& device) const noexcept;
  bool leave_jam(const Vec3& device) noexcept;
  bool leave_along(const Vec3& device, const Vec3& motion, bool& closed) noexcept;
  enum class Lift : std::uint8_t { things, planes };
  bool lift(double height, Lift over) noexcept;
  Vec3 normal_to_proxy(std::uint32_t triangle) const noexcept;
  bool is_better(const Vec3& device) const noexcept;
  ConstrainedMotion next_motion(const Vec3& goal) noexcept;
  Vec3 rub(const Vec3& goal, const ConstrainedMotion& constrained) noexcept;
  bool cross_emptiness(const Vec3& device) noexcept;
  bool advance(const Vec3& motion) noexcept;
  double sweep(const Vec3& from, const Vec3& motion) noexcept;
  Neighbourhood& near() noexcept { return neighbourhoods_[here_]; }
  const Neighbourhood& near() const noexcept { return neighbourhoods_[here_]; }
  Neighbourhood& next_near() noexcept { return neighbourhoods_[1 - here_]; }
  void forget_near() noexcept;
  void look_ahead(const Vec3& motion) noexcept;
  bool stay_near(const Vec3& start, const Vec3& motion, double room, double ahead) noexcept;
  void note_grazed(const Separation& at, std::uint32_t triangle) noexcept;
  void note_blocker(std::uint32_t triangle, double t) noexcept;
  void step_off_surface() noexcept;
  void settle_at(const Vec3& p) noexcept;
  void keep_touching(const Vec3& blocked_motion) noexcept;
  bool forget_doubtful(const ConstrainedMotion& held) noexcept;
  double find_empty_ball(const Vec3& device, double may_go) noexcept;
  void enter_ball(const Vec3& p_SD, double radius) noexcept;
  void leave_ball() noexcept;
  Material touched_material() const noexcept;
  Material material_of(const ConstrainedMotion& held) const noexcept;
  bool can_touch(std::uint32_t triangle, const Vec3& p) const noexcept;

  TouchGeometry geometry_;
  std::vector<Material> surfaces_;  // one an object
  Clearance clearance_;
  double shading_ = 0.0;
  double hover_ = 0.0;
  double off_ = 0.0;  // of what holds the proxy: the force leaves it out
  bool is_point_ = true;
  bool has_one_sided_ = false;
  bool has_friction_ = false;
  SurfaceFollower surface_;                 // while it stands, it holds the proxy
  SurfacePoint glance_;                     // at a vertex that a flight comes to
  bool short_of_rest_ = false;              // it ran out of events
  std::unique_ptr<SphereFollower> sphere_;  // of a probe with a radius

  Vec3 proxy_ = Vec3::Zero();             // local
  Vec3 last_device_ = Vec3::Zero();       // local
  bool free_ = true;                      // proxy is the device point
  bool placed_ = false;                   // a first sample has come
  bool sliding_ = false;                  // Coulomb state
  int sweeps_left_ = 0;                   // of this step's
  double stride_ = 0.0;                   // how far the device moved in this step
  Vec3 empty_center_S_ = Vec3::Zero();    // the scene's frame, m, like the next two
  double empty_radius_squared_m2_ = 0.0;  // no triangle is within this of the centre plus the probe's rest distance; 0: no ball is known
  Vec3 last_free_S_ = Vec3::Zero();       // the last sample in the ball: while one is known, proxy_ and last_device_ lag behind
  double empty_retry_ = 0.0;              // travel before the next search for an empty ball is worth its cost

  std::array<Neighbourhood, 2> neighbourhoods_;  // where the probe is, and where it goes
  int here_ = 0;                                 // in neighbourhoods_
  enum class Ahead : std::uint8_t { begun, nothing, found, fetched, too_much } ahead_ = Ahead::nothing;  // how far the other one is
  std::array<Neighbourhood::Meeting, Neighbourhood::kCapacity> meetings_;
  double near_reach_ = 0.0;  // half the size of the next neighbourhood beyond the probe's own

  std::array<Touch, kMaxTouching> touching_;
  int touching_count_ = 0;
  std::array<double, 3> push_ = {0, 0, 0};  // of the first pushing_count_ of touching_, which hold the proxy
  int pushing_count_ = 0;
  bool met_fold_ = false;  // in this step, a way from facet to facet did
  Stand before_;           // the step
  Stand part_;             // a part of it
  Stand rest_;             // what an escape is tried from
  std::array<Exit, kMaxExits> exits_;
  int exit_count_ = 0;
  Vec3 exits_from_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  std::array<ContactPlane, kMaxTouching> planes_;
  std::array<Blocker, kMaxTouching> blockers_;  // what stopped the last sweep
  int blocker_count_ = 0;
  ProxyCounters counters_;
};

}  // namespace hapton
