#include "core/force/streamed_method.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/carried_proxy.h"
#include "core/force/deforming_method.h"
#include "core/math/commanded_motion.h"

namespace hapton {

Result<std::unique_ptr<StreamedMethod>> StreamedMethod::make(const MethodSettings& settings, std::shared_ptr<const TriangleMesh> mesh,
                                                             const Material& material, double reach_m) {
  if (!(reach_m > 0.0) || !std::isfinite(reach_m)) {
    return fail("a reach of {} m; give the largest distance of a vertex from its position in the mesh, above 0", reach_m);
  }
  if (mesh == nullptr || mesh->triangles.empty()) return fail("the mesh has no triangles; give it a surface to touch");
  // A deformation in which nothing moves makes the proxy ready for vertices that move.
  auto no_motion = std::make_shared<const MeshDeformation>(std::vector{MorphTarget{.vertices = {0}, .displacements = {Vec3::Zero()}}},
                                                           std::vector{MorphKey{.time_s = 0.0, .weights = {0.0}}}, false);
  TouchScene scene;
  scene.objects.push_back({.mesh = mesh, .material = material, .deformation = std::move(no_motion)});
  auto method = make_proxy_of_deforming(settings, scene, bounds_with_reach(*mesh, reach_m));
  if (!method) return tl::unexpected(method.error());
  auto stager = std::make_shared<const ShapeStager>(static_cast<const ProxyMethod&>(**method).geometry(), std::move(mesh), reach_m);
  return std::unique_ptr<StreamedMethod>(new StreamedMethod(std::move(*method), std::move(stager)));
}

StreamedMethod::StreamedMethod(std::unique_ptr<ForceMethod> method, std::shared_ptr<const ShapeStager> stager)
    : stager_(std::move(stager)),
      carried_(std::make_unique<CarriedProxy<StreamedGeometry>>(std::move(method), stager_->make_rest())),
      surface_(carried_->surface()) {}

StreamedMethod::~StreamedMethod() = default;

MethodOutput StreamedMethod::step(const MethodInput& input) noexcept { return carried_->step(input); }

void StreamedMethod::reset(const Vec3& p_SD) noexcept { carried_->reset(p_SD); }

void StreamedMethod::resume(const Vec3& p_SP) noexcept { carried_->resume(p_SP); }

void StreamedMethod::set_materials(std::span<const Material> materials) noexcept { carried_->method().set_materials(materials); }

std::optional<SurfacePlace> StreamedMethod::find_place(int /*object*/) const noexcept { return carried_->find_place(); }

double StreamedMethod::last_time_s() const noexcept { return carried_->last_time_s(); }

std::optional<Vec3> StreamedMethod::held_at() const noexcept { return carried_->held_at(); }

double StreamedMethod::compute_time_s(const ShapeStage& stage, double over_s) noexcept {
  return std::max(over_s, stage.most_m / kMaxSurfaceSpeed);
}

StreamedGeometry::Released StreamedMethod::offer(std::unique_ptr<ShapeStage> stage, double over_s) noexcept {
  const double seconds = compute_time_s(*stage, over_s);
  return surface_.offer(std::move(stage), seconds, last_time_s());
}

std::string StreamedMethod::describe() const {
  return fmt::format("a program gives its shapes: {} vertices, {:.3g} MB\n", stager_->rest().size(),
                     static_cast<double>(surface_.bytes()) * 1e-6) +
         carried_->method().describe();
}

}  // namespace hapton
