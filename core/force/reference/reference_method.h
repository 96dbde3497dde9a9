#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/force/force_method.h"
#include "core/force/reference/reference_proxy.h"

namespace hapton {

// What the reference did since the last reset.
struct ReferenceCounters {
  std::uint64_t steps = 0;
  std::uint64_t unsettled_steps = 0;  // steps whose force still changed at the most sub-steps
  std::uint64_t candidates = 0;       // triangles within reach, summed over steps
  std::uint64_t most_substeps = 0;    // of one step that settled
  ReferenceProxy::Counters proxy;     // over all doublings
};

// How the last step ended.
struct ReferenceStep {
  bool settled = true;
  int substeps = 1;     // of the result
  double change = 0.0;  // of the force between the last two doublings, relative
};

// The judge of the other methods: slow, plain and independent of them. It gives the limit that ever finer sub-steps approach.
//
// Definition. The proxy P follows the device D on its straight motion from sample to sample. In each of N equal sub-steps P moves, in
// straight pieces that cross no triangle, to the constrained local minimum of |P - D|: the pull D - P is projected onto the half-spaces of
// the triangles P is in contact with (Zilles & Salisbury 1995; a sphere's contact normals as Ruspini et al. 1997), the motion is followed
// by continuous collision against every triangle, what it meets becomes a contact, and so on until nothing moves beyond rounding. Where a
// minimum ends P follows the gradient flow of |P - D|: its way keeps to the surface, and leaves a vertex the steepest way. Coulomb
// friction holds P where the tangential part of the pull is within the cone, and drags it along its own lag else
// (core/force/friction_drag.h). Force = stiffness (P - D), less damping along it, never pulling.
//
// Limit. Each step is done with N = reference_substeps, 2 N, 4 N ... sub-steps, always from the state at its start; one in which P jumps
// under friction is halved until the moment of the jump is known to a billionth of it. That goes on until two successive results agree:
// force and place to kAgreement of the larger force, and the sliding state. The finer result goes on. Where they still differ at
// reference_substep_limit the step has not settled: its finest result goes on and it is counted; last_step() tells. Nothing is
// extrapolated. Agreement is relative, or kResolution of the scene's diagonal where that is more: what rounding explains after the radius
// of a point probe has been taken off.
//
// There is no search structure: each step takes from all triangles' boxes those within the ball the proxy cannot leave, since its distance
// to the device never grows beyond what the device itself moves. `prefilter` false takes all of them; the result is the same to the bit.
// Everything is computed relative to the scene's centre in units of its diagonal's next power of two, so scale and place do not matter.
// Frame: S. RT: no heap, lock or system call in step and reset, but no bound on time either.
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

  // Puts the proxy at p_SP with the device at p_SD and lets it come to rest, without friction: a judge of whether p_SP was a minimum. A
  // proxy on a face, however near to its border, is taken to stand on the face. The proxy must not lie within rounding of a surface it
  // should stay on one side of; one at rest on a surface is fine.
  MethodOutput settle_from(const Vec3& p_SP, const Vec3& p_SD) noexcept;

  // Goes on from another method's state: its proxy, at rest at p_SP with the device at p_SD, and whether friction had it slide. The proxy
  // is lifted off the surface by twice a point's radius, away from the device; a point under friction stands on the faces nearest to it.
  // Step goes on from there. Counters are kept.
  void resume(const Vec3& p_SP, const Vec3& p_SD, bool sliding) noexcept;

  const ReferenceCounters& counters() const { return counters_; }
  const ReferenceStep& last_step() const { return last_; }

 private:
  ReferenceMethod(const MethodSettings& settings, const TouchScene& scene, bool prefilter);

  Vec3 to_local(const Vec3& p_S) const { return (p_S - centre_) / unit_m_; }
  Vec3 to_scene(const Vec3& p) const { return p * unit_m_ + centre_; }
  Vec3 device_to_local(const Vec3& p_S) const noexcept;
  PreparedTriangle prepare_triangle(std::uint32_t triangle) const;
  void gather(const Vec3& device, double reach) noexcept;
  void follow(const Vec3& from, const Vec3& to, int substeps) noexcept;
  void follow_substep(const Vec3& from, const Vec3& to, std::size_t level) noexcept;
  void follow_to_the_limit(const Vec3& from, const Vec3& to) noexcept;
  MethodOutput compute_output(const Vec3& p_SD, const Vec3& place, const Vec3& velocity_m_per_s) const noexcept;

  Vec3 centre_;
  double unit_m_ = 1.0;  // a power of two: scaling by it is exact
  int substeps_ = 1;
  int substep_limit_ = 1;
  bool prefilter_ = true;
  std::vector<Vec3> vertices_;            // local
  std::vector<Triangle> triangles_;       // into vertices_
  std::vector<std::uint32_t> object_of_;  // of triangles_
  std::vector<float> low_[3], high_[3];   // boxes of triangles_, rounded outwards
  std::vector<std::uint8_t> in_reach_;    // of triangles_, this step

  std::unique_ptr<ReferenceProxy> proxy_;
  ReferenceProxy::State start_;                // of the step
  std::vector<ReferenceProxy::State> levels_;  // of a sub-step and its halves
  int halvings_left_ = 0;
  Vec3 device_ = Vec3::Zero();
  bool placed_ = false;
  ReferenceStep last_;
  ReferenceCounters counters_;
};

}  // namespace hapton
