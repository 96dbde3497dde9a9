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

// The surfaces of a scene's objects as they are drawn, for annotations on them. Points are in the object's frame O (scene/annotations.h).
// On an object that deforms, a point is kept in the mesh at rest (DeformedMesh), and place() moves it with the surface. On an object that
// is carved, a point stays where it was touched, even when the material there is gone. Metres. Threads: one. RT: no.
class AnnotatedSurfaces {
 public:
  // Pre: the scene outlives this.
  explicit AnnotatedSurfaces(const Scene& scene);

  // Sets the source of the surfaces of carved objects; without it they are as in the scene file. Pre: it outlives this, or is null.
  void set_carved_objects(const CarvedObjects* carved) { carved_ = carved; }

  // Sets the source of the shapes of objects that programs deform; without it they are at rest. Pre: not null; it outlives this; its time
  // is set before set_time() is called here.
  void set_moved_objects(const MovedObjects* moved);

  // Gives objects that deform the shape that they have at this scene time (ProbeState).
  void set_time(std::int64_t scene_time_ns);
  // Increases whenever set_time() changed a shape.
  std::uint64_t revision() const { return revision_; }
  // Whether any object deforms; if not, place() changes nothing.
  bool has_deforming() const { return has_deforming_; }

  struct TouchedPoint {
    Vec3 p_O = Vec3::Zero();
    std::uint32_t facet = 0;  // as Pen::receive() takes it
  };
  // The point of an object's surface that is closest to p (frame O, in the present shape); if the object deforms, its place at rest. The
  // first call for an object takes 0.3 s for a million triangles. Pre: object < scene.objects.size(); p is finite.
  TouchedPoint find_closest(std::size_t object, const Vec3& p);

  // Moves points with the surface into its present shape. Points of an object that the scene does not have do not change.
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
  std::vector<std::optional<DeformedMesh>> deformed_;      // by object; none: it does not deform
  std::vector<std::optional<KnownShapes::Place>> places_;  // by object: the last place of its shape; none: not known yet
  std::vector<std::unique_ptr<SurfaceFinder>> finders_;    // by object; null until an object that does not deform is first touched
  std::uint64_t revision_ = 0;
};

}  // namespace hapton
