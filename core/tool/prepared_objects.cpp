#include "core/tool/prepared_objects.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// Largest coordinate of the scene in a frame that still suits it, local units. In a new frame, too, all coordinates are within 1.
constexpr double kFarthest = 1.0;
// Least diagonal of the scene in a frame that still suits it; in a new frame it is 1 to 2. Tolerances are in proportion to the local unit.
constexpr double kMinDiagonal = 0.5;

std::vector<Box> bounds_of(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes) {
  std::vector<Box> bounds;
  for (const auto& mesh : meshes) bounds.push_back(Box::of(mesh->vertices));
  return bounds;
}

}  // namespace

PreparedObjects::PreparedObjects(std::vector<std::shared_ptr<const TriangleMesh>> meshes, std::optional<double> shading_crease_rad)
    : meshes_(std::move(meshes)),
      shading_crease_rad_(shading_crease_rad),
      bounds_(bounds_of(meshes_)),
      geometries_(meshes_.size()),
      prepared_(meshes_.size()),
      frame_(TouchGeometry::frame_of(scene_bounds())),
      most_triangles_(TouchGeometry::most_triangles(meshes_)) {}

Box PreparedObjects::scene_bounds() const {
  Box scene;
  for (const Box& bounds : bounds_) scene.grow(bounds);
  return scene;
}

bool PreparedObjects::suits_frame(const Box& bounds) const {
  if (bounds.is_empty()) return true;
  const Vec3 low = frame_.to_local(bounds.low);
  const Vec3 high = frame_.to_local(bounds.high);
  return std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()) <= kFarthest && (high - low).norm() >= kMinDiagonal;
}

void PreparedObjects::replace(std::size_t object, std::shared_ptr<const TriangleMesh> mesh) {
  meshes_[object] = std::move(mesh);
  bounds_[object] = Box::of(meshes_[object]->vertices);
  geometries_[object].reset();
  prepared_[object].reset();
  const Box bounds = scene_bounds();
  const std::size_t most = TouchGeometry::most_triangles(meshes_);
  if (most == most_triangles_ && suits_frame(bounds)) return;
  most_triangles_ = most;
  frame_ = TouchGeometry::frame_of(bounds);
  std::ranges::fill(geometries_, nullptr);
  std::ranges::fill(prepared_, nullptr);
}

const std::shared_ptr<const ObjectGeometry>& PreparedObjects::build_geometry(std::size_t object) {
  std::shared_ptr<const ObjectGeometry>& geometry = geometries_[object];
  if (geometry == nullptr) {
    geometry = std::make_shared<const ObjectGeometry>(ObjectGeometry::make(*meshes_[object], frame_, most_triangles_, shading_crease_rad_));
  }
  return geometry;
}

bool PreparedObjects::prepare_next() {
  const auto next = std::ranges::find(prepared_, nullptr);
  if (next == prepared_.end()) return false;
  *next = std::make_shared<const ContactSurface>(build_geometry(static_cast<std::size_t>(next - prepared_.begin())));
  return true;
}

std::shared_ptr<const BuiltObjects> PreparedObjects::build() {
  if (!TouchGeometry::check(meshes_)) return nullptr;
  for (std::size_t o = 0; o < meshes_.size(); ++o) build_geometry(o);
  auto built = std::make_shared<BuiltObjects>();
  built->frame = frame_;
  built->shading_crease_rad = shading_crease_rad_;
  built->meshes = meshes_;
  for (const Box& bounds : bounds_) built->bounds.push_back(TouchGeometry::local_bounds(frame_, bounds));
  built->objects = marked_.update(geometries_, built->bounds);
  return built;
}

Result<std::unique_ptr<ToolStep>> PreparedObjects::hold(std::size_t object, const Pose& X_SD, const ToolCoupling& coupling,
                                                        std::vector<CoulombFriction> friction, std::unique_ptr<WorkerTeam> team,
                                                        std::vector<int> parts) {
  if (const auto numbered = TouchGeometry::check(meshes_); !numbered) return tl::unexpected(numbered.error());
  while (prepare_next()) {
  }
  PreparedTool tool{.tool = prepared_[object],
                    .grip = frame_.to_local(X_SD.translation()),
                    .q_DT = Quat(X_SD.linear()).normalized().conjugate(),
                    .mean_squared_lever = find_mean_squared_lever(*meshes_[object], X_SD.translation()),
                    .scene = prepared_,
                    .frame = frame_,
                    .part_of = std::move(parts)};
  tool.scene.erase(tool.scene.begin() + static_cast<std::ptrdiff_t>(object));
  return ToolStep::make(tool, coupling, std::move(friction), std::move(team));
}

std::size_t PreparedObjects::bytes() const {
  std::size_t bytes = 0;
  for (const auto& object : prepared_) bytes += object != nullptr ? object->bytes() : 0;
  return bytes;
}

}  // namespace hapton
