#include "vision_node/annotated_surfaces.h"

#include <memory>
#include <variant>

namespace hapton {

AnnotatedSurfaces::AnnotatedSurfaces(const Scene& scene)
    : scene_(&scene), deformed_(scene.objects.size()), places_(scene.objects.size()), finders_(scene.objects.size()) {
  for (std::size_t o = 0; o < deformed_.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    if (object.deformation == nullptr) continue;
    deformed_[o].emplace(object.mesh, object.deformation);
    has_deforming_ = true;
  }
  set_time(0);
}

void AnnotatedSurfaces::set_moved_objects(const MovedObjects* moved) {
  moved_ = moved;
  for (std::size_t o = 0; o < deformed_.size(); ++o) {
    if (scene_->objects[o].program_shape == nullptr) continue;
    deformed_[o].emplace(scene_->objects[o].mesh, [moved, o] { return moved->find_vertices(o); });
    places_[o].reset();
    has_deforming_ = true;
  }
}

void AnnotatedSurfaces::set_time(std::int64_t scene_time_ns) {
  for (std::size_t o = 0; o < deformed_.size(); ++o) {
    if (!deformed_[o]) continue;
    if (deformed_[o]->set_time(1e-9 * static_cast<double>(scene_time_ns))) ++revision_;
    if (scene_->objects[o].program_shape == nullptr) continue;
    const auto place = moved_->shape_place(o);
    if (!place || place == places_[o]) continue;
    places_[o] = place;
    deformed_[o]->invalidate_vertices();
    ++revision_;
  }
}

AnnotatedSurfaces::TouchedPoint AnnotatedSurfaces::find_closest(std::size_t object, const Vec3& p) {
  if (deformed_[object]) {
    const DeformedMesh::TouchedPoint touched = deformed_[object]->find_closest(p);
    return {touched.p_rest, touched.triangle};
  }
  if (carved_ != nullptr) {
    if (const auto closest = carved_->find_closest(object, p)) return {*closest};
  }
  if (finders_[object] == nullptr) finders_[object] = std::make_unique<SurfaceFinder>(scene_->objects[object].mesh);
  return {finders_[object]->find_closest(p).point};
}

const DeformedMesh* AnnotatedSurfaces::find_deformed(std::int32_t object) const {
  const auto number = static_cast<std::size_t>(object);
  return object >= 0 && number < deformed_.size() && deformed_[number] ? &*deformed_[number] : nullptr;
}

Vec3 AnnotatedSurfaces::place(const AnnotationPoint& point) const {
  const DeformedMesh* deformed = find_deformed(point.object);
  return deformed != nullptr ? deformed->place(point.p_O) : point.p_O;
}

std::vector<Vec3> AnnotatedSurfaces::place(std::int32_t object, const std::vector<Vec3>& points) const {
  std::vector<Vec3> placed = points;
  if (find_deformed(object) == nullptr) return placed;
  for (Vec3& p : placed) p = place(AnnotationPoint{object, p});
  return placed;
}

Measure AnnotatedSurfaces::place(const Measure& measure) const {
  Measure placed = measure;
  for (AnnotationPoint& end : placed.ends) end.p_O = place(end);
  return placed;
}

Annotations AnnotatedSurfaces::place(const Annotations& annotations) const {
  Annotations placed = annotations;
  for (Annotation& entry : placed.entries) {
    std::visit([&](auto& each) { each = place(each); }, entry);
  }
  return placed;
}

}  // namespace hapton
