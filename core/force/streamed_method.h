#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/collision/shape_stage.h"
#include "core/force/force_method.h"

namespace hapton {

template <class Surface>
class CarriedProxy;

// The method `proxy` for one surface whose shapes are not known beforehand: a program sends one after the other, and the vertices move
// in straight lines from each shape to the next. The forces are those of DeformingMethod with these shapes as keyframes.
//
// A shape is prepared outside of the step (stager()), and handed over (offer()) as a stage from the shape that the current stage leads to.
// If another stage has begun meanwhile (serial() has changed), the shape has to be prepared again. No vertex is faster than
// kMaxSurfaceSpeed: a stage that would be faster takes longer.
//
// Frame: S. RT: all but make, destruction, describe and vertices; step is linear in the vertices, a few ns each, while the hand is near the
// surface. Threads: one; const calls of stager() from any, beside the steps.
class StreamedMethod final : public ForceMethod {
 public:
  // reach_m: the largest distance of a vertex from its place in the mesh. Error: a mesh without triangles; a reach_m that is
  // not finite or not above 0; what DeformingMethod rejects.
  static Result<std::unique_ptr<StreamedMethod>> make(const MethodSettings& settings, std::shared_ptr<const TriangleMesh> mesh,
                                                      const Material& material, double reach_m);

  ~StreamedMethod() override;

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  void resume(const Vec3& p_SP) noexcept override;
  std::optional<Vec3> held_at() const noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::optional<SurfacePlace> find_place(int object) const noexcept override;
  std::string describe() const override;

  const ShapeStager& stager() const { return *stager_; }
  // The same stager, shared: it may be used after the method is destroyed.
  std::shared_ptr<const ShapeStager> share_stager() const { return stager_; }
  // The stage that moves at the time of the last step; if none does, the last that ended. serial(): the number of stages that have begun.
  const ShapeStage& current_stage() const noexcept { return surface_.present(); }
  std::uint64_t serial() const noexcept { return surface_.serial(); }
  // The stage follows the current one, and replaces one that waits. over_s: how long it is to take. Returned: stages that are no longer
  // used, to be destroyed outside of the loop. Pre: it begins where the current stage ends; at most one waits; over_s 0 or more.
  StreamedGeometry::Released offer(std::unique_ptr<ShapeStage> stage, double over_s) noexcept;
  // The stage follows all that wait: it begins at the scene time start_s and takes over_s. Returned: a stage that is no longer used; null:
  // none. Pre: fewer than kMaxWaiting wait; it begins where newest_stage() ends; start_s is after the last step, and not before end_s();
  // over_s is not below compute_time_s().
  std::unique_ptr<ShapeStage> offer_at(std::unique_ptr<ShapeStage> stage, double start_s, double over_s) noexcept {
    return surface_.append(std::move(stage), over_s, start_s);
  }
  static constexpr std::size_t kMaxWaiting = StreamedGeometry::kMaxWaiting;
  // How many stages wait for their start; the last of them, else the current one; and the scene time at which that one ends.
  std::size_t waiting() const noexcept { return surface_.waiting(); }
  const ShapeStage& newest_stage() const noexcept { return surface_.newest(); }
  double end_s() const noexcept { return surface_.end_s(); }
  double last_time_s() const noexcept;
  // How long a stage takes: over_s, or longer where a vertex would be faster than kMaxSurfaceSpeed.
  static double compute_time_s(const ShapeStage& stage, double over_s) noexcept;

  // The shape at the time of the last step. RT: no.
  std::vector<Vec3> vertices() const { return surface_.vertices_at(last_time_s()); }

 private:
  StreamedMethod(std::unique_ptr<ForceMethod> method, std::shared_ptr<const ShapeStager> stager);

  std::shared_ptr<const ShapeStager> stager_;
  std::unique_ptr<CarriedProxy<StreamedGeometry>> carried_;
  StreamedGeometry& surface_;  // of carried_
};

}  // namespace hapton
