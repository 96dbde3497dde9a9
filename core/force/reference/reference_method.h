#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/force/force_method.h"
#include "core/force/reference/reference_proxy.h"
#include "core/force/reference/triangle_boxes.h"

namespace hapton {

// Counters since the last reset.
struct ReferenceCounters {
  std::uint64_t steps = 0;
  std::uint64_t unsettled_steps = 0;  // steps whose force still changed at the largest number of sub-steps
  std::uint64_t candidates = 0;       // triangles near the proxy, summed over steps
  std::uint64_t most_substeps = 0;    // largest number of sub-steps of a step that settled
  ReferenceProxy::Counters proxy;     // summed over all passes; most_motions is the largest
};

// How the last step ended.
struct ReferenceStep {
  bool settled = true;
  int substeps = 1;     // of the pass that gave the result
  double change = 0.0;  // of P - D (see below) between the last two passes, relative to the longer one
};

// The reference that other methods are compared with: slow, simple and independent of them. It computes the limit that ever finer sub-steps
// approach.
//
// Definition. The proxy P follows the device D on its straight motion from sample to sample. In each of N equal sub-steps P moves, in
// straight pieces that cross no triangle, to the constrained local minimum of |P - D|. The pull D - P is projected onto the half-spaces of
// the triangles P is in contact with (Zilles & Salisbury 1995; a sphere's contact normals as Ruspini et al. 1997). Continuous collision
// detection tests the projected motion against every triangle; what P hits becomes a contact; this repeats until P does not move beyond
// rounding. Where a minimum ceases to exist, P follows the gradient flow of |P - D|: its path stays on the surface and leaves a vertex in
// the steepest direction. Coulomb friction holds P while the tangential part of the pull is within the cone, and else drags it along the
// pull (core/force/sliding_friction.h). Force = stiffness (P - D), less damping along it, never attractive.
//
// Limit. Each step is computed with N = reference_substeps, 2 N, 4 N ... sub-steps, always from the state at its start. A sub-step in which
// P jumps under friction is halved until the part with the jump is at most 2^-38 local units long, with at most 1024 halvings in a pass.
// The doubling ends when two successive results agree: P - D to kAgreement of the longer of the two, or to kResolution local units if that
// is more (the rounding left after the radius of a point probe has been subtracted); stiffness and sliding state exactly. The finer result
// is used. If they still differ at reference_substep_limit, the step is unsettled: its finest result is used, it is counted, and
// last_step() says so. Nothing is extrapolated.
//
// Without a search structure, each step takes all triangles whose boxes are in a ball around D that P cannot leave, as |P - D| never grows
// by more than the motion of D. With `prefilter` false it takes all; the result is bit for bit the same. All computation is relative to the
// scene's centre, in local units (ReferenceProxy): scale and position do not matter. Frame: S. RT: no heap, lock or system call in step and
// reset, but unbounded time. Error of make: settings or vertices out of range; no triangle.
class ReferenceMethod final : public ForceMethod {
 public:
  static constexpr double kAgreement = 1e-9;
  static constexpr double kResolution = 0x1p-42;

  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);
  static Result<std::unique_ptr<ReferenceMethod>> make_reference(const MethodSettings& settings, const TouchScene& scene,
                                                                 bool prefilter = true);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::string describe() const override;

  // Puts the proxy at p_SP with the device at p_SD and lets it settle without friction: if the result is still at p_SP, that was a local
  // minimum. A proxy on a face, however near to its boundary, counts as on the face. Pre: p_SP is clear of surfaces by more than rounding,
  // or a proxy's minimum on them. The proxy may stop before it settles, once it is nearer to the device than `near_enough_m`.
  MethodOutput settle_from(const Vec3& p_SP, const Vec3& p_SD, double near_enough_m = 0.0) noexcept;

  void set_materials(std::span<const Material> materials) noexcept override { proxy_->set_materials(materials); }
  // Continues from another method's proxy at rest at p_SP, with the device at p_SD; `sliding`: that proxy slid under friction. The proxy is
  // put at p_SP if it has room, else lifted from the device by twice a point's radius, and settles for this device; a point with friction
  // is put onto the faces nearest to p_SP, without settling, if that succeeds. The next step continues from there. Counters are kept.
  void continue_from(const Vec3& p_SP, const Vec3& p_SD, bool sliding) noexcept;

  const ReferenceCounters& counters() const { return counters_; }
  const ReferenceStep& last_step() const { return last_step_; }

 private:
  ReferenceMethod(const MethodSettings& settings, const TouchScene& scene, bool prefilter);

  Vec3 to_local(const Vec3& p_S) const { return (p_S - centre_) / unit_m_; }
  Vec3 to_scene(const Vec3& p) const { return p * unit_m_ + centre_; }
  Vec3 device_to_local(const Vec3& p_S) const noexcept;
  PreparedTriangle prepare_triangle(std::uint32_t triangle) const;
  void gather(const Vec3& device, double bound) noexcept;
  void follow(const Vec3& from, const Vec3& to, int substeps) noexcept;
  void follow_substep(const Vec3& from, const Vec3& to, std::size_t level) noexcept;
  void follow_to_the_limit(const Vec3& from, const Vec3& to) noexcept;
  MethodOutput compute_output(const Vec3& p_SD, const Vec3& position, const Vec3& velocity_m_per_s) const noexcept;

  Vec3 centre_;
  double unit_m_ = 1.0;  // local unit: a power of two, so scaling by it is exact
  int substeps_ = 1;
  int substep_limit_ = 1;
  bool prefilter_ = true;
  std::vector<Vec3> vertices_;              // local
  std::vector<Triangle> triangles_;         // into vertices_
  std::vector<std::uint32_t> object_of_;    // of triangles_
  std::optional<TriangleBoxes> boxes_;      // of triangles_
  std::vector<PreparedTriangle> prepared_;  // triangles_; empty if they are many

  std::unique_ptr<ReferenceProxy> proxy_;
  ReferenceProxy::State start_state_;                // at the start of the step
  std::vector<ReferenceProxy::State> level_states_;  // before a sub-step and before each of its halves, by level of halving
  int halvings_left_ = 0;
  Vec3 device_ = Vec3::Zero();
  Vec3 sample_before_ = Vec3::Zero();  // the device position in the sample before, for damping
  bool has_sample_ = false;
  ReferenceStep last_step_;
  ReferenceCounters counters_;
};

}  // namespace hapton
