#include "core/tool/prepared_objects.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// A scene is within this of its frame's origin, local units; a new frame has it within 1.
constexpr double kFarthest = 1.0;
// And its diagonal is at least this; in a new frame it is 1 to 2. Tolerances are in proportion to it.
constexpr double kLeastDiagonal = 0.5;

Box bounds_of(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes) {
  Box bounds;
  for (const auto& mesh : meshes) {
    for (const Vec3& v : mesh->vertices) bounds.grow(v);
  }
  return bounds;
}

}  // namespace

PreparedObjects::PreparedObjects(std::vector<std::shared_ptr<const TriangleMesh>> meshes)
    : meshes_(std::move(meshes)),
      prepared_(meshes_.size()),
      frame_(TouchGeometry::frame_of(bounds_of(meshes_))),
      most_triangles_(TouchGeometry::most_triangles(meshes_)) {}

bool PreparedObjects::suits_frame(const Box& bounds) const {
  if (bounds.is_empty()) return true;
  const Vec3 low = frame_.to_local(bounds.low);
  const Vec3 high = frame_.to_local(bounds.high);
  return std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()) <= kFarthest && (high - low).norm() >= kLeastDiagonal;
}

void PreparedObjects::replace(std::size_t object, std::shared_ptr<const TriangleMesh> mesh) {
  meshes_[object] = std::move(mesh);
  prepared_[object].reset();
  const Box bounds = bounds_of(meshes_);
  const std::size_t most = TouchGeometry::most_triangles(meshes_);
  if (most == most_triangles_ && suits_frame(bounds)) return;
  most_triangles_ = most;
  frame_ = TouchGeometry::frame_of(bounds);
  std::ranges::fill(prepared_, nullptr);
}

bool PreparedObjects::prepare_next() {
  const auto next = std::ranges::find(prepared_, nullptr);
  if (next == prepared_.end()) return false;
  *next = std::make_shared<const ContactSurface>(*meshes_[static_cast<std::size_t>(next - prepared_.begin())], frame_, most_triangles_);
  return true;
}

Result<std::unique_ptr<ToolStep>> PreparedObjects::hold(std::size_t object, const Pose& X_SD, const ToolCoupling& coupling,
                                                        std::vector<SurfaceFriction> friction, std::unique_ptr<WorkerTeam> team) {
  if (const auto numbered = TouchGeometry::check(meshes_); !numbered) return tl::unexpected(numbered.error());
  while (prepare_next()) {
  }
  PreparedTool tool{.tool = prepared_[object],
                    .grip = frame_.to_local(X_SD.translation()),
                    .q_DT = Quat(X_SD.linear()).normalized().conjugate(),
                    .mean_squared_lever = find_mean_squared_lever(*meshes_[object], X_SD.translation()),
                    .scene = prepared_,
                    .frame = frame_};
  tool.scene.erase(tool.scene.begin() + static_cast<std::ptrdiff_t>(object));
  return ToolStep::make(tool, coupling, std::move(friction), std::move(team));
}

std::size_t PreparedObjects::bytes() const {
  std::size_t bytes = 0;
  for (const auto& object : prepared_) bytes += object != nullptr ? object->bytes() : 0;
  return bytes;
}

}  // namespace hapton
