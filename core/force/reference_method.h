#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/force/force_method.h"
#include "core/force/half_space_projection.h"
#include "core/geometry/closest_point.h"

namespace hapton {

// What the reference did since the last reset.
struct ReferenceCounters {
  std::uint64_t steps = 0;
  std::uint64_t settles = 0;       // sub-steps that met triangles
  std::uint64_t motions = 0;       // straight pieces of the proxy's way
  std::uint64_t most_motions = 0;  // in one settle
  std::uint64_t unsettled = 0;     // settles stopped by the bound on motions: a valid proxy, short of the minimum
  std::uint64_t escapes = 0;       // corners left that only the probe's radius had closed
  std::uint64_t infeasible = 0;    // projections that rounding left without a solution
  std::uint64_t candidates = 0;    // triangles within reach, summed over steps
};

// The judge of the other methods: slow, plain and independent of them.
//
// Definition. The proxy P follows the device D. In each of `reference_substeps` equal parts of a step's device motion P moves, in straight
// pieces that cross no triangle, to the constrained local minimum of |P - D|: the wish D - P is projected onto the half-spaces of the
// triangles P touches (Zilles & Salisbury 1995; a sphere's contact normals as Ruspini et al. 1997), the motion is followed by continuous
// collision against every triangle, what it meets joins the touched ones, and so on until nothing moves beyond rounding. A point probe is a
// sphere of radius 2^-32 of the scene's diagonal, so distances decide and never signs: no edge, corner or crack narrower than that lets it
// through. Force = stiffness (P - D), less damping along it, never pulling; Coulomb friction stops P where the tangential part of the wish
// is within the cone, per sub-step. There is no search structure: each step takes from all triangles' boxes those within the ball the proxy
// cannot leave, since its distance to the device never grows beyond what the device itself moves. `prefilter` false takes all of them; the
// result is the same to the bit. Everything is computed relative to the scene's centre in units of its diagonal's next power of two, so
// scale and place do not matter. Frame: S. RT: no heap, lock or system call in step and reset, but no bound on time either.
class ReferenceMethod final : public ForceMethod {
 public:
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);
  static Result<std::unique_ptr<ReferenceMethod>> make_reference(const MethodSettings& settings, const TouchScene& scene,
                                                                 bool prefilter = true);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::string describe() const override;

  // Puts the proxy at p_SP with the device at p_SD and lets it settle, without friction: a judge of whether p_SP was a minimum. A proxy on
  // a face, however near to its border, is taken to stand on the face. The proxy must not lie within rounding of a surface it should stay
  // on one side of; one at rest on a surface is fine.
  MethodOutput settle_from(const Vec3& p_SP, const Vec3& p_SD) noexcept;

  const ReferenceCounters& counters() const { return counters_; }

 private:
  struct Face {
    PreparedTriangle shape;
    std::uint32_t triangle = 0;
    std::uint32_t object = 0;
  };
  struct Touch {
    Face face;
    ClosestPoint near;
  };
  struct Box {
    Vec3 low, high;
  };
  struct Wish {
    HalfSpaceProjection motion;  // from the proxy
    const Touch* strongest = nullptr;
  };

  ReferenceMethod(const MethodSettings& settings, const TouchScene& scene, bool prefilter);

  Vec3 to_local(const Vec3& p_S) const { return (p_S - centre_) / unit_m_; }
  Vec3 to_scene(const Vec3& p) const { return p * unit_m_ + centre_; }
  Vec3 device_to_local(const Vec3& p_S) const noexcept;
  PreparedTriangle prepare_triangle(std::uint32_t triangle) const;
  void gather(const Vec3& device, double reach) noexcept;
  void settle(const Vec3& device) noexcept;
  void descend(const Vec3& device) noexcept;
  bool escape(const Vec3& device) noexcept;
  bool is_on_open_face() const noexcept;
  void collect_near(const Vec3& p, double within) noexcept;
  bool lift(const Vec3& start, double height) noexcept;
  const std::vector<Vec3>& directions_out(const Vec3& start, const Vec3& wish, double within) noexcept;
  bool cross_emptiness(const Vec3& device) noexcept;
  void look_at_touched() noexcept;
  Wish project_wish(const Vec3& wish) noexcept;
  Material material_of(const Wish& wish) const noexcept;
  Vec3 hold_back(const Wish& wish) noexcept;
  bool has_friction() const { return !frictionless_ && !friction_off_; }
  bool roll(const Vec3& device, const Wish& wish) noexcept;
  bool tip_over(const Vec3& device, const Wish& wish) noexcept;
  bool tip_over(const Vec3& device, const Touch& touch) noexcept;
  Vec3 pivot_of(const Touch& touch) const noexcept;
  static Vec3 edge_of(const Touch& touch) noexcept;
  static Vec3 across_feature(const Touch& touch, const Vec3& v) noexcept;
  bool go_round(const Touch& touch, const Vec3& tangent, double angle) noexcept;
  bool advance(const Vec3& motion) noexcept;
  void touch(const Face& face) noexcept;
  bool can_touch(const Face& face) const noexcept;
  MethodOutput felt(const Vec3& p_SD, const Vec3& velocity_m_per_s) const noexcept;

  Vec3 centre_;
  double unit_m_ = 1.0;  // a power of two: scaling by it is exact
  double rest_ = 0.0;    // distance of the proxy's centre from what it touches
  double skin_ = 0.0;    // play of that distance
  int substeps_ = 8;
  bool prefilter_ = true;
  bool frictionless_ = true;
  std::vector<Material> materials_;
  std::vector<Vec3> vertices_;            // local
  std::vector<Triangle> triangles_;       // into vertices_
  std::vector<std::uint32_t> object_of_;  // of triangles_
  std::vector<float> low_[3], high_[3];   // boxes of triangles_, rounded outwards

  std::vector<std::uint8_t> in_reach_;  // of triangles_, this step
  std::vector<Face> candidates_;
  std::vector<Box> candidate_boxes_;
  std::vector<Touch> touched_;
  std::vector<Touch> touched_before_;
  std::vector<Touch> near_;
  std::vector<Vec3> directions_;
  std::vector<HalfSpace> half_spaces_;
  Vec3 proxy_ = Vec3::Zero();
  Vec3 device_ = Vec3::Zero();
  Material felt_material_;
  bool placed_ = false;
  bool free_ = true;
  bool sliding_ = false;
  bool friction_off_ = false;
  bool tips_borders_ = true;
  ReferenceCounters counters_;
};

}  // namespace hapton
