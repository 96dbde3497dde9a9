#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scene/annotations.h"
#include "scene/scene_file.h"
#include "vision_node/carved_objects.h"
#include "vision_node/deformed_mesh.h"
#include "vision_node/moved_objects.h"

namespace hapton {

// The surfaces of a scene's objects as they are drawn, for what is drawn on them. Frame O (scene/annotations.h), of an object that deforms
// with its mesh at rest (DeformedMesh): such a point goes along with the surface. A point of an object that is carved stays where it was
// touched, also where the material is gone. Metres. Threads: one. RT: no.
class AnnotatedSurfaces {
 public:
  // Pre: it outlives this.
  explicit AnnotatedSurfaces(const Scene& scene);

  // Objects that are carved; without, they are as in the scene file. Pre: it outlives this.
  void set_carved_objects(const CarvedObjects* carved) { carved_ = carved; }

  // What knows the shapes of objects that programs deform; without, they are at rest. Pre: it outlives this, and its time is set before
  // set_time().
  void set_moved_objects(const MovedObjects* moved);

  // The time of ProbeState: from now on, objects that deform have their shape of then.
  void set_time(std::int64_t scene_time_ns);
  // Counts the times that one had another shape.
  std::uint64_t revision() const { return revision_; }
  // Whether any object deforms; otherwise all points are where they are kept.
  bool has_deforming() const { return has_deforming_; }

  struct Touched {
    Vec3 p_O = Vec3::Zero();
    std::uint32_t facet = 0;  // as Pen::receive() takes it
  };
  // The point of an object's surface that is closest to p, a point of frame O of the present shape. The first time it takes 0.3 s for a
  // million triangles. Pre: a number of an object; finite.
  Touched find_closest(std::size_t object, const Vec3& p);

  // Where they are in the present shape. Of objects that the scene does not have: as they are.
  Vec3 place(const AnnotationPoint& point) const;
  std::vector<Vec3> place(std::int32_t object, const std::vector<Vec3>& points) const;
  Stroke place(const Stroke& stroke) const { return {stroke.object, place(stroke.object, stroke.points_m)}; }
  Measure place(const Measure& measure) const;
  Annotations place(const Annotations& annotations) const;

 private:
  const DeformedMesh* find_deformed(std::int32_t object) const;

  const Scene* scene_;
  const CarvedObjects* carved_ = nullptr;
  bool has_deforming_ = false;
  const MovedObjects* moved_ = nullptr;
  std::vector<std::optional<DeformedMesh>> deformed_;      // by object; none: it is rigid
  std::vector<std::optional<KnownShapes::Place>> places_;  // by object, of the shape that it has; none: not known yet
  std::vector<std::unique_ptr<SurfaceFinder>> finders_;    // by object, made when one that is rigid is first drawn on
  std::uint64_t revision_ = 0;
};

}  // namespace hapton
