#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "core/collision/swept_sphere.h"
#include "core/collision/triangle_cache.h"
#include "core/force/contact_qp.h"
#include "core/force/force_method.h"
#include "core/force/proxy/surface_follower.h"
#include "core/force/sphere/sphere_follower.h"

namespace hapton {

class FacetDescent;

// Counters since construction. In steps unless stated.
struct ProxyCounters {
  std::uint64_t steps = 0;
  std::uint64_t skipped = 0;  // free-space steps within the empty ball, without a query
  std::uint64_t contact_steps = 0;
  std::uint64_t iterations = 0;         // constrained motions solved in contact steps
  std::uint64_t sweeps = 0;             // continuous collision queries
  std::uint64_t rebuilds = 0;           // triangle cache rebuilds
  std::uint64_t prefetched = 0;         // rebuilds whose triangles had been prefetched
  std::uint64_t tests = 0;              // triangle against moving sphere
  std::uint64_t substepped = 0;         // steps repeated in sub-steps
  std::uint64_t substepped_finely = 0;  // steps repeated in kSubsteps sub-steps
  std::uint64_t facet_descents = 0;     // minima found by FacetDescent, without a sweep
  double shading_squared = 0.0;         // sum over contact steps of (|shaded - unshaded| / |unshaded|)^2
  double shading_most = 0.0;            // largest |shaded - unshaded| / |unshaded|
  std::uint64_t escapes = 0;            // local minima of the contact-offset sphere left because a point would not stop there
  std::uint64_t attempts = 0;           // attempts at that
  std::uint64_t flights = 0;            // motions through free space
  std::uint64_t swept = 0;              // steps finished by sweeps
  std::uint64_t exhausted = 0;          // steps that ran out of events; the rest was carried into the next step
  std::uint64_t most_events = 0;        // in one step
  std::uint64_t slips = 0;              // pieces of a sphere's path that slip with the device held still
  std::uint64_t unconverged = 0;        // steps stopped by the iteration limit: the proxy is valid but short of the minimum
};

// The god-object (point probe) and sphere probe, iterated to convergence: in every step the proxy moves, without crossing a surface, to the
// constrained local minimum of its distance to the device (Zilles & Salisbury 1995, Ruspini et al. 1997). We differ in continuous motion
// against the triangles themselves, exact active sets, and convergence within the step.
//
// Where sweeps move it, a point probe is a sphere whose radius is the contact offset, 2^-30 of the scene's size. Distances decide, never
// signs of volumes: the proxy's distance to every triangle stays above half the contact offset on its whole path, so edges, vertices and
// cracks narrower than the contact offset are as tight as faces, and both sides of a sheet are equal.
//
// Optional force shading (Morgenbesser & Srinivasan 1996) turns the force towards interpolated smooth normals without changing its
// magnitude or the proxy; describe() reports by how much.
//
// Force = stiffness * (proxy - device), less damping * normal velocity; Coulomb friction limits how far the proxy follows.
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
  static constexpr int kMaxContacts = 32;
  static constexpr int kMaxExits = 64;
  static constexpr double kBeside = 512.0;  // contact offsets: distance within which an edge or vertex affects the proxy
  static constexpr int kMaxEscapes = 8;     // per step
  static constexpr int kMaxIterations = 256;
  static constexpr int kMaxSweeps = 4096;           // per step; a step that reaches it ends at a valid proxy and continues in the next
  static constexpr int kEscapeSweeps = 64;          // reserved for one escape
  static constexpr double kLookAheadSteps = 500.0;  // steps: 0.5 s at 1 kHz; an object is requested this long before the probe can reach it
  static constexpr double kLargestCacheRadius = 2.0;  // local units: the scene's size
  static constexpr double kLongestMotion = 4.0;       // local units: twice the scene's size
  static constexpr int kMaxIdle = 6;
  static constexpr double kOutrun = 1.3;                // displacements: a longer step is checked by sub-steps
  static constexpr double kOutrunAtConcaveEdge = 1.01;  // the same where a concave edge is involved
  static constexpr double kJump = 1.5;                  // displacements: a longer step counts as a jump
  static constexpr double kReleaseJump = 4.0;  // displacements of the sub-step: a longer one is a release, as no slide is that fast
  static constexpr int kSubsteps = 8;
  static constexpr double kSamePosition = 0x1p-16;  // displacements: closer results are the same position
  static constexpr int kNearPieces = 4;
  static constexpr double kCacheMargin = 0.25;   // share of the path: least margin of the cache beside it
  static constexpr double kCacheAhead = 0.8;     // share of the cache radius: distance of the cache's centre ahead of the proxy
  static constexpr double kPrefetchSteps = 3.5;  // steps: a cache that the proxy leaves sooner is prefetched
  static constexpr int kFewNear = 32;            // triangles: below this the next cache is larger,
  static constexpr int kManyNear = 64;           // and above this smaller

  struct Contact {
    std::uint32_t triangle = 0;
    std::uint32_t slot = TriangleCache::kNoSlot;  // last known slot in the triangle cache
    ContactTriangle shape;
    Separation separation;
  };
  // A snapshot of the proxy, restored when an attempt fails.
  struct State {
    Vec3 proxy = Vec3::Zero();
    bool free = true;
    bool sliding = false;
    std::array<std::uint32_t, kMaxContacts> triangles;
    std::array<Separation, kMaxContacts> separations;
    int contact_count = 0;
    std::array<double, 3> multipliers = {0, 0, 0};
    int active_count = 0;
  };
  // A direction along an edge in which the proxy may leave a vertex.
  struct Exit {
    Vec3 direction = Vec3::Zero();  // unit
    bool closed = false;            // known to be blocked
  };
  struct Blocker {
    std::uint32_t triangle = 0;
    double time = 0.0;
  };

  ProxyMethod(const MethodSettings& settings, const TouchScene& scene);

  std::string describe_steps() const;

  [[gnu::noinline]] MethodOutput step_outside(const MethodInput& input) noexcept;
  void bring_active_first(const ConstrainedMotion& held) noexcept;
  Vec3 shaded(const Vec3& extension) noexcept;
  Vec3 force_of(const Vec3& extension_m, const Vec3& velocity_m_per_s) const noexcept;
  bool involves_concave_edge() const noexcept;
  bool has_outrun_device() const noexcept;
  bool has_left_concave_edge() const noexcept;
  enum class Doubt : std::uint8_t { none, slight, great };
  Doubt doubt_of_step() const noexcept;
  void follow(const Vec3& last, const Vec3& device) noexcept;
  void follow_by_sweeps(const Vec3& last, const Vec3& device) noexcept;
  bool follow_surface(const Vec3& last, const Vec3& device, double& time) noexcept;
  bool follow_offset(const Vec3& last, const Vec3& device, double& time) noexcept;
  void copy_sphere_state(const Vec3& device) noexcept;
  enum class Met : std::uint8_t { nothing, walkable, other };
  Met fly(const Vec3& from, const Vec3& to, bool slides, double& time) noexcept;
  bool is_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, const Vec3& hit) noexcept;
  bool is_vertex_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, int k, const Vec3& hit) noexcept;
  void clear_start() noexcept;
  void lift_off_surface() noexcept;
  bool land_on_surface() noexcept;
  void hold_by_surface(const Vec3& device) noexcept;
  void follow_in_substeps(const Vec3& last, const Vec3& device, int count) noexcept;
  void solve(const Vec3& device) noexcept;
  bool walk(const Vec3& device) noexcept;
  FacetDescent facets() noexcept;
  bool is_open_to(const FacetDescent& descent) const noexcept;
  void descend(const Vec3& device) noexcept;
  static Vec3 shortened(const Vec3& motion) noexcept;
  ContactTriangle shape_of(std::uint32_t triangle) const noexcept;
  void save(State& state) const noexcept;
  void restore(const State& state) noexcept;
  bool escape(const Vec3& device) noexcept;
  bool tip_over(const Vec3& device) noexcept;
  bool tip(const Vec3& device, const Vec3& sideways) noexcept;
  bool is_in_corner() const noexcept;
  void find_exits() noexcept;
  bool leave_corner(const Vec3& device) noexcept;
  bool is_wedged(const Vec3& device) const noexcept;
  bool leave_wedge(const Vec3& device) noexcept;
  bool leave_along(const Vec3& device, const Vec3& motion, bool& closed) noexcept;
  enum class Lift : std::uint8_t { triangles, planes };
  bool lift(double height, Lift over) noexcept;
  Vec3 normal_to_proxy(std::uint32_t triangle) const noexcept;
  bool is_better(const Vec3& device) const noexcept;
  ConstrainedMotion next_motion(const Vec3& goal) noexcept;
  Vec3 apply_friction(const Vec3& goal, const ConstrainedMotion& constrained) noexcept;
  bool cross_empty_space(const Vec3& device) noexcept;
  bool advance(const Vec3& motion) noexcept;
  double sweep(const Vec3& from, const Vec3& motion) noexcept;
  TriangleCache& cache() noexcept { return caches_[current_]; }
  const TriangleCache& cache() const noexcept { return caches_[current_]; }
  TriangleCache& next_cache() noexcept { return caches_[1 - current_]; }
  void forget_near() noexcept;
  void prefetch_cache(const Vec3& motion) noexcept;
  bool keep_cached(const Vec3& start, const Vec3& motion, double room, double ahead) noexcept;
  void note_grazed(const Separation& at, std::uint32_t triangle) noexcept;
  void note_blocker(std::uint32_t triangle, double t) noexcept;
  void step_off_surface() noexcept;
  void settle_at(const Vec3& p) noexcept;
  void update_contacts(const Vec3& blocked_motion) noexcept;
  bool forget_doubtful(const ConstrainedMotion& held) noexcept;
  double find_empty_ball(const Vec3& device, double may_go) noexcept;
  void enter_ball(const Vec3& p_SD, double radius) noexcept;
  void leave_ball() noexcept;
  Material contact_material() const noexcept;
  Material material_of(const ConstrainedMotion& held) const noexcept;
  bool can_touch(std::uint32_t triangle, const Vec3& p) const noexcept;

  TouchGeometry geometry_;
  std::vector<Material> surfaces_;  // by object
  Clearance clearance_;
  double shading_ = 0.0;
  double contact_offset_ = 0.0;
  double active_offset_ = 0.0;  // contact offset of the active constraint, which the force does not include
  bool is_point_ = true;
  bool has_one_sided_ = false;
  bool has_friction_ = false;
  SurfaceFollower surface_;                 // holds the proxy while is_on_surface()
  SurfacePoint vertex_probe_;               // scratch: the vertex that a flight reaches
  bool unconverged_ = false;                // the last step ran out of events
  std::unique_ptr<SphereFollower> sphere_;  // follows a probe with a radius, and a point on triangles that are not walkable

  Vec3 proxy_ = Vec3::Zero();             // local
  Vec3 last_device_ = Vec3::Zero();       // local
  bool free_ = true;                      // no contact: the proxy is the device point
  bool has_sample_ = false;               // a first sample has arrived
  bool sliding_ = false;                  // the dynamic coefficient applies
  int sweeps_left_ = 0;                   // of this step
  double displacement_ = 0.0;             // distance that the device moved in this step
  Vec3 empty_centre_S_ = Vec3::Zero();    // frame S, m, as the next two
  double empty_radius_squared_m2_ = 0.0;  // no triangle lies within this of the centre plus the probe's rest offset; 0: no ball known
  Vec3 last_free_S_ = Vec3::Zero();       // last sample in the ball; proxy_ and last_device_ are not updated while a ball is known
  double empty_retry_ = 0.0;              // distance to travel before the next search for an empty ball

  std::array<TriangleCache, 2> caches_;  // current, and prefetched
  int current_ = 0;                      // index into caches_
  enum class Prefetch : std::uint8_t {
    rebuilt,
    nothing,
    found,
    fetched,
    too_much
  } prefetch_ = Prefetch::nothing;  // state of the prefetched cache
  std::array<TriangleCache::Candidate, TriangleCache::kCapacity> candidates_;
  double cache_radius_ = 0.0;  // half side of the next cache, without the probe's own size

  std::array<Contact, kMaxContacts> contacts_;
  int contact_count_ = 0;
  std::array<double, 3> multipliers_ = {0, 0, 0};  // of the first active_count_ of contacts_
  int active_count_ = 0;
  bool met_concave_edge_ = false;  // a facet descent in this step met a concave edge
  State before_step_;              // state before the step
  State before_substep_;           // state before a sub-step
  State equilibrium_;              // state that an escape starts from
  std::array<Exit, kMaxExits> exits_;
  int exit_count_ = 0;
  Vec3 exits_from_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  std::array<ContactPlane, kMaxContacts> planes_;
  std::array<Blocker, kMaxContacts> blockers_;  // triangles that stopped the last sweep
  int blocker_count_ = 0;
  ProxyCounters counters_;
};

}  // namespace hapton
