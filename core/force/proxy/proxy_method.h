#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/force/force_method.h"
#include "core/force/proxy/empty_ball.h"
#include "core/force/proxy/free_flight.h"
#include "core/force/proxy/proxy_state.h"
#include "core/force/proxy/surface_follower.h"
#include "core/force/proxy/swept_motion.h"
#include "core/force/sphere/sphere_follower.h"

namespace hapton {

// Counters since construction. In steps unless stated.
struct ProxyCounters {
  std::uint64_t steps = 0;
  std::uint64_t skipped = 0;  // free-space steps within the empty ball, without a query
  std::uint64_t contact_steps = 0;
  double shading_squared = 0.0;   // sum over contact steps of (|shaded - unshaded| / |unshaded|)^2
  double shading_most = 0.0;      // largest |shaded - unshaded| / |unshaded|
  std::uint64_t flights = 0;      // motions through free space
  std::uint64_t swept = 0;        // steps finished by sweeps
  std::uint64_t exhausted = 0;    // steps that ran out of work; the rest was carried into the next step
  std::uint64_t most_events = 0;  // in one step
  int most_work = 0;              // in one step: units (step_work.h)
};

// The god-object (point probe) and sphere probe: in every step the proxy moves, without crossing a surface, to the constrained local
// minimum of its distance to the device (Zilles & Salisbury 1995, Ruspini et al. 1997). It differs from theirs: it follows the device's
// straight motion from event to event, and converges within the step. Its parts, and what each of them follows:
//
//   SurfaceFollower   a point on walkable triangles, by adjacency
//   FreeFlight        a point off the surface
//   SphereFollower    a probe with a radius; a point on triangles that are not walkable
//   SweptMotion       steps whose events cannot be told apart
//   EmptyBall         free space
//
// Where the surface deforms between two steps (DeformingMethod), it takes the probe along: see Anchor.
//
// Optional force shading (Morgenbesser & Srinivasan 1996) turns the force towards interpolated smooth normals without changing its
// magnitude or the proxy; describe() reports by how much.
//
// Force = stiffness * (proxy - device), less damping * normal velocity; Coulomb friction limits how far the proxy follows.
// Frame: S. RT: step, reset, held_at, resume and carried_from yes.
class ProxyMethod final : public ForceMethod {
 public:
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);
  // The crease angle of the smooth normals that the method needs (BuiltObjects), rad; none: it needs no smooth normals.
  static std::optional<double> shading_crease_rad(const MethodSettings& settings);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::optional<Vec3> held_at() const noexcept override;
  std::optional<Vec3> carried_from() const noexcept override;
  void resume(const Vec3& p_SP) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  bool prepare() override;
  std::string describe() const override;

  // A point on one side of the surface: where the surface holds the probe, or the nearest point visible from a free probe. As long as the
  // deforming surface does not touch itself, the same point of the deformed surface is on the probe's side of the whole surface.
  struct Anchor {
    bool exists = false;
    std::uint32_t triangle = 0;
    bool back = false;
    Vec3 weights = Vec3::Zero();  // of the triangle's corners
    Vec3 point = Vec3::Zero();    // local units, as `distance`
    double distance = 0.0;        // from a free probe to the point; without a point, how far was searched; 0: the probe is held
  };
  // Call before the surface deforms. A free probe gets no anchor if no surface is nearer than reach_m; it needs none if no point of the
  // surface moves farther than reach_m.
  Anchor anchor(double reach_m) noexcept;
  // Call after the surface has deformed: puts the probe at the anchor, and moves the last device position by as much as the anchor has
  // moved, so that the next step goes from there to the device. Without an anchor the probe stays.
  void move_with_surface(const Anchor& anchor) noexcept;
  // The next sample corrects a sample that this method did not get. p_SD: the device in the sample before the missing one, for damping.
  void note_sample_before(const Vec3& p_SD) noexcept;
  // The point of the surface that holds the probe most: a triangle, and the weights of its corners. None: the probe is free.
  struct HeldPlace {
    std::uint32_t triangle = 0;
    Vec3 weights = Vec3::Zero();
  };
  std::optional<HeldPlace> find_held_place() const noexcept;
  // In contact under friction: the dynamic coefficient applies, though the proxy may have stopped for now. RT: yes.
  bool is_sliding() const noexcept { return proxy_.slides; }
  // For a method that was made of one object that deforms.
  TouchGeometry& deforming_geometry() { return geometry_; }

  const ProxyCounters& counters() const { return counters_; }
  const SweptMotion& swept() const { return swept_; }
  const SphereFollower& sphere() const { return sphere_; }
  const TouchGeometry& geometry() const { return geometry_; }
  const Clearance& clearance() const { return clearance_; }

 private:
  // The contact offset, local units. 2^21 times the rounding of local coordinates, so distances of this size keep six digits; far below
  // what can be felt (1e-10 m on a 100 mm scene).
  static constexpr double kContactOffset = 0x1p-30;
  // How often the sphere follower may fail in one motion; after that sweeps finish it, as the two could undo each other's work without end.
  // Also how often the motion may be carried on after a sweep. A choice.
  static constexpr int kMaxFailures = 4;
  static constexpr double kEdgeReach = 512.0;       // contact offsets: distance within which an edge or vertex affects the proxy
  static constexpr double kLookAheadSteps = 500.0;  // steps: 0.5 s at 1 kHz; an object is requested this long before the probe can reach it

  ProxyMethod(const MethodSettings& settings, const TouchScene& scene);

  static TouchGeometry make_geometry(const MethodSettings& settings, const TouchScene& scene);
  static Clearance clearance_of(const MethodSettings& settings, double unit_m);
  std::string describe_steps() const;

  // Units of work (step_work.h).
  static constexpr int kMinSweptWork = 100;  // a sweep may always use this much: what the followers cannot finish goes on

  [[gnu::noinline]] MethodOutput step_outside(const MethodInput& input) noexcept;
  // Returns where the device's motion to this sample begins: at the last sample, or where the last step ran out of work.
  Vec3 begin_motion(const MethodInput& input, const Vec3& last) noexcept;
  // Requests the objects ahead of the probe. Returns the radius of the empty ball around the device, local; 0: none found or not searched.
  double find_empty_radius(const Vec3& device, double displacement) noexcept;
  MethodOutput render_contact(const MethodInput& input, const Vec3& device) noexcept;
  void leave_ball() noexcept;
  Vec3 shaded(const Vec3& extension) noexcept;
  Material felt_material() const noexcept;
  Vec3 force_of(const Vec3& extension_m, const Vec3& velocity_m_per_s) const noexcept;
  void follow(const Vec3& last, const Vec3& device) noexcept;
  void arrive_from_far(const Vec3& device) noexcept;
  void follow_piece(const Vec3& last, const Vec3& device) noexcept;
  bool follow_surface(const Vec3& last, const Vec3& device, double& time) noexcept;
  FreeFlight::Met fly_to_device(const Vec3& from, const Vec3& device, double& time) noexcept;
  bool follow_offset(const Vec3& last, const Vec3& device, double& time) noexcept;
  bool sweep_to(const Vec3& device) noexcept;
  void sweep_from_slit(const Vec3& last, const Vec3& device) noexcept;
  bool is_nearer_than_sphere(const Vec3& device) const noexcept;
  bool sweep_past_slit(const Vec3& device) noexcept;
  void follow_after_sweep(const Vec3& last, const Vec3& device) noexcept;
  void copy_sphere_state(const Vec3& device) noexcept;
  void carry(const Vec3& device) noexcept;
  void move_start_off_surfaces() noexcept;
  std::optional<std::uint32_t> find_nearest(const Vec3& p, double reach, Separation& at) const noexcept;
  bool is_nearer_to_surface(const Vec3& p, double distance) const noexcept;
  void lift_off_surface() noexcept;
  bool land_on_surface() noexcept;
  void hold_by_surface(const Vec3& device) noexcept;

  struct Lifted {
    Vec3 from = Vec3::Zero();
    double distance = 0.0;
  };
  // In the motion to one sample, over all steps that this motion takes.
  struct Tries {
    int failures = 0;                // of the sphere follower
    int sweep_carries = 0;           // carries after a sweep that left no work, when the device had already reached the sample
    bool is_left_to_sweeps = false;  // a flight among too many triangles has given up: no other one while the sphere touches nothing
    std::optional<Lifted> lifted;    // where the proxy was last lifted off the surface, and how far

    void forget() noexcept {
      failures = sweep_carries = 0;
      is_left_to_sweeps = false;
      lifted.reset();
    }
  };

  TouchGeometry geometry_;
  std::vector<Material> materials_;  // by object
  ProxySurfaces surfaces_;
  Clearance clearance_;  // what sweeps keep; to sweeps, a point is a sphere whose radius is the contact offset
  double shading_ = 0.0;
  double active_offset_ = kContactOffset;  // contact offset of the active constraint, which the force does not include
  bool is_point_ = true;
  SurfaceFollower surface_;  // holds the proxy while is_on_surface()
  SphereFollower sphere_;    // follows a probe with a radius, and a point on triangles that are not walkable
  FreeFlight flight_;
  SweptMotion swept_;
  EmptyBall ball_;  // while a ball is known, proxy_, last_device_ and sample_before_ are not updated

  ProxyState proxy_;
  Vec3 last_device_ = Vec3::Zero();    // local
  Vec3 sample_before_ = Vec3::Zero();  // local: the device in the sample before this one; damping acts on the motion from there
  std::optional<Vec3> carried_from_;   // after a step without enough work: where on the device's path the next step goes on; local
  int work_left_ = 0;                  // of this step
  bool has_sample_ = false;            // a first sample has arrived
  bool is_unconverged_ = false;        // the proxy on the surface must first descend to its local minimum
  Tries tries_;
  bool is_at_sphere_offset_ = false;  // in a slit, a sweep has left a point only as far from surfaces as the sphere follower keeps it
  int touched_object_ = -1;           // the object of the last contact, until the proxy is free; -1: none
  ProxyCounters counters_;
};

}  // namespace hapton
