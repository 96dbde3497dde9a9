#include "patch/patch_shaper.h"

#include <utility>

namespace hapton {

// Null: the surface cannot take that shape.
std::unique_ptr<ShapeStage> PatchShaper::make_stage(const StreamedParts& parts, const KnownShapes& shapes, std::uint32_t serial) {
  serial_ = serial;
  const auto displacements_m = shapes.displacements_m(static_cast<std::size_t>(parts.object()), {serial, serial, 1.0});
  std::vector<Vec3> to = parts.vertices_at(stager_->rest(), displacements_m);
  auto stage = stager_->make(base_vertices_, to);
  if (!stage) return nullptr;
  base_vertices_ = std::move(to);
  return std::move(*stage);
}

Result<std::unique_ptr<StreamedMethod>> PatchShaper::make(const MethodSettings& settings, const TouchObject& object,
                                                          const StreamedParts& parts, const KnownShapes& shapes,
                                                          std::int64_t scene_time_ns) {
  forget();
  const auto place = shapes.find(static_cast<std::size_t>(parts.object()), scene_time_ns);
  if (!place) return std::unique_ptr<StreamedMethod>();
  auto method = StreamedMethod::make(settings, object.mesh, object.material, *object.stream_reach_m);
  if (!method) return method;
  ++number_;
  stager_ = (*method)->share_stager();
  base_vertices_.assign(stager_->rest().begin(), stager_->rest().end());
  serial_ = 0;
  // The surface has had this shape since before the first step: its stage takes no time.
  if (place->before != 0) {
    auto first = make_stage(parts, shapes, place->before);
    if (first == nullptr) return fail("the surface on the grid of its parts cannot take its present shape");
    (void)(*method)->offer_at(std::move(first), 0.0, 0.0);
  }
  if (place->to == place->before) return method;
  const ShapeStart* const start = shapes.find_start(static_cast<std::size_t>(parts.object()), place->to);
  auto second = start != nullptr ? make_stage(parts, shapes, place->to) : nullptr;
  if (second == nullptr) return method;
  (void)(*method)->offer_at(std::move(second), 1e-9 * static_cast<double>(start->start_ns),
                            1e-9 * static_cast<double>(start->end_ns - start->start_ns));
  return method;
}

std::unique_ptr<PatchShape> PatchShaper::make_next(const StreamedParts& parts, const KnownShapes& shapes, std::int64_t scene_time_ns) {
  if (stager_ == nullptr) return nullptr;
  const ShapeStart* const start = shapes.find_next(static_cast<std::size_t>(parts.object()), serial_, scene_time_ns);
  if (start == nullptr) return nullptr;
  auto stage = make_stage(parts, shapes, start->serial);
  if (stage == nullptr) return nullptr;
  return std::make_unique<PatchShape>(PatchShape{std::move(stage), number_, start->start_ns, start->end_ns});
}

}  // namespace hapton
