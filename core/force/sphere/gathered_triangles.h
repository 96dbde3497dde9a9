#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "core/collision/near_triangles.h"
#include "core/collision/swept_sphere.h"
#include "core/force/sphere/centre_path.h"
#include "core/force/touch_scene.h"

namespace hapton {

// The triangles around a sphere's centre, gathered once for many steps (NearTriangles), and what they let the centre do. The radius adapts
// itself so that there are some dozens of them. Slots are those of NearTriangles, and are valid until the next call of gather(), reach(),
// cover(), is_clear_here(), clear() or reset().
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h). `c`: the centre.
class GatheredTriangles : public NearTriangles {
 public:
  // `materials`: one for each object. Both outlive this object. `least_radius`: see gather(); beyond the offset.
  GatheredTriangles(const TouchGeometry& geometry, std::span<const Material> materials, const Clearance& clearance, double least_radius)
      : geometry_(geometry), materials_(materials), clearance_(clearance), least_radius_(least_radius) {}

  const TouchGeometry& geometry() const { return geometry_; }
  const Material& material(std::uint32_t triangle) const { return materials_[geometry_.mesh_of(triangle)]; }
  // Whether a sphere can touch the triangle from the side on which p is.
  bool can_touch(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& p) const noexcept {
    return material(triangle).two_sided || shape.normal().dot(p - shape.corner(0)) > 0.0;
  }

  // Gathers a ball whose centre lies ahead in the direction `towards`. False: there are too many triangles even within the least radius.
  // Then it does not try again before the centre has moved by a quarter of the offset.
  bool gather(const Vec3& c, const Vec3& towards, int& work) noexcept;
  // Whether the gathered triangles cover a ball of radius `distance` around c; if they do not yet, gathers them around c.
  bool reach(const Vec3& c, double distance, int& work) noexcept {
    return covers(c, distance) || (gather(c, Vec3::Zero(), work) && covers(c, distance));
  }
  // The search for the next ball begins with at least that radius beyond the offset.
  void widen(double radius) { radius_ = std::max(radius_, radius); }
  // Gathers triangles so that they cover the path up to `until`, or lowers `until`. False: they cover no part of the path.
  bool cover(const CentrePath& path, double& until, int& work) noexcept;
  // Whether no triangle that c can touch is nearer than offset - short_by. `short_by`: the slop, plus the error of a c computed elsewhere.
  // Pre: covers(c, offset).
  bool is_clear(const Vec3& c, double short_by, int& work) noexcept;
  // The same without the Pre: gathers triangles if necessary. False also if that fails.
  bool is_clear_here(const Vec3& c, double short_by, int& work) noexcept;

  // The set of triangles has changed: gather them again.
  void clear() {
    NearTriangles::clear();
    crowded_at_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  }
  // As constructed, except for the counter.
  void reset() {
    clear();
    last_count_ = 0;
    radius_ = 0.0;
  }
  std::uint64_t gathered() const { return gather_count_; }  // balls, since construction

 private:
  bool are_slivers(double radius) const noexcept;

  const TouchGeometry& geometry_;
  std::span<const Material> materials_;
  Clearance clearance_;
  double least_radius_;
  Vec3 crowded_at_ = Vec3::Constant(std::numeric_limits<double>::infinity());  // where there were too many triangles to gather
  int last_count_ = 0;                                                         // number of triangles gathered the last time
  double radius_ = 0.0;                                                        // of the next ball, beyond the offset; 0: none yet
  std::uint64_t gather_count_ = 0;
};

}  // namespace hapton
