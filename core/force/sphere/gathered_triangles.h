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

// The triangles around a sphere's centre, gathered once for many steps (NearTriangles), with a radius that adapts itself so that they are
// some dozens, and what they let the centre do. Slots are those of NearTriangles, and are valid until the next call of gather(), reach(),
// cover() or is_clear_here().
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h). `c`: the centre.
class GatheredTriangles : public NearTriangles {
 public:
  // `materials`: one for each object. Both outlive this object. `least_radius`: of a gathered ball, beyond the offset.
  GatheredTriangles(const TouchGeometry& geometry, std::span<const Material> materials, const Clearance& clearance, double least_radius)
      : geometry_(geometry), materials_(materials), clearance_(clearance), least_radius_(least_radius) {}

  const TouchGeometry& geometry() const { return geometry_; }
  const Material& material(std::uint32_t triangle) const { return materials_[geometry_.mesh_of(triangle)]; }
  // Whether the side of a triangle that p is on holds a sphere.
  bool can_touch(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& p) const noexcept {
    return material(triangle).two_sided || shape.normal().dot(p - shape.corner(0)) > 0.0;
  }

  // Gathers a ball whose centre lies ahead in the direction `towards`. False: within the least radius there are too many triangles. Then it
  // is not tried again before the centre has gone some way.
  bool gather(const Vec3& c, const Vec3& towards, int& work) noexcept;
  // Whether the gathered triangles cover a ball around the centre; if not, they are gathered there.
  bool reach(const Vec3& c, double distance, int& work) noexcept {
    return covers(c, distance) || (gather(c, Vec3::Zero(), work) && covers(c, distance));
  }
  // The next ball has at least that radius beyond the offset.
  void widen(double radius) { radius_ = std::max(radius_, radius); }
  // Gathers triangles so that they cover the path, or its beginning up to that time.
  bool cover(const CentrePath& path, double& until, int& work) noexcept;
  // Whether no triangle is nearer than allowed. `short_by`: by how much a start that only other code computed may be too near.
  // Pre: covers(c, offset).
  bool is_clear(const Vec3& c, double short_by, int& work) noexcept;
  // The same, wherever the gathered triangles are.
  bool is_clear_here(const Vec3& c, double short_by, int& work) noexcept;

  // The set of triangles has changed: gather them again.
  void clear() {
    NearTriangles::clear();
    crowd_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  }
  // As constructed, except for the counter.
  void reset() {
    clear();
    last_count_ = 0;
    radius_ = 0.0;
  }
  std::uint64_t gathered() const { return gathered_; }  // balls, since construction

 private:
  bool are_slivers(double radius) const noexcept;

  const TouchGeometry& geometry_;
  std::span<const Material> materials_;
  Clearance clearance_;
  double least_radius_;
  Vec3 crowd_ = Vec3::Constant(std::numeric_limits<double>::infinity());  // where there were too many triangles to gather
  int last_count_ = 0;                                                    // triangles the last time
  double radius_ = 0.0;                                                   // of the next ball, beyond the offset; 0: none yet
  std::uint64_t gathered_ = 0;
};

}  // namespace hapton
