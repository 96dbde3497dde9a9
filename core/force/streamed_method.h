#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/collision/shape_stage.h"
#include "core/force/force_method.h"

namespace hapton {

template <class Surface>
class RidingProxy;

// The method `proxy` for one surface whose shapes are not known beforehand: a program gives one after the other, and the vertices move
// straight from each to the next. It is what DeformingMethod does for keyframes with these shapes.
//
// A shape is prepared outside of the step (stager()), and handed over (offer()) as a stage from the shape that the present stage leads to.
// If the present stage has become another one meanwhile (serial()), the shape has to be prepared again. No vertex is faster than
// kMostSurfaceSpeed: a stage that would be faster takes longer.
//
// Frame: S. RT: step, reset, set_materials and offer yes: linear in the vertices, a few ns each, where the hand is near. Threads: as
// ForceMethod; stager() any, beside the steps.
class StreamedMethod final : public ForceMethod {
 public:
  // reach_m: no vertex will ever be farther than that from where it is in the mesh. Error: a mesh without triangles; a reach that is not
  // finite or not above 0; what DeformingMethod rejects.
  static Result<std::unique_ptr<StreamedMethod>> make(const MethodSettings& settings, std::shared_ptr<const TriangleMesh> mesh,
                                                      const Material& material, double reach_m);

  ~StreamedMethod() override;

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::optional<SurfacePlace> find_place(int object) const noexcept override;
  std::string describe() const override;

  const ShapeStager& stager() const { return *stager_; }
  // The stage that moves at the time of the last step, or has ended.
  const ShapeStage& present() const noexcept;
  std::uint64_t serial() const noexcept;
  // The stage comes after the present one, and takes the place of one that waits. over_s: how long it shall take. Returned: stages that are
  // used no more, to be destroyed outside of the loop. Pre: it begins where the present stage ends; over_s 0 or more.
  StreamedGeometry::Released offer(std::unique_ptr<ShapeStage> stage, double over_s) noexcept;
  // The same, with its time: it begins at start_s and takes over_s. Pre: no stage waits; start_s is after the last step, and not before the
  // present stage ends; over_s is not below compute_time_s.
  StreamedGeometry::Released offer_at(std::unique_ptr<ShapeStage> stage, double start_s, double over_s) noexcept;
  // A stage waits for its beginning.
  bool has_waiting() const noexcept;
  // How long a stage takes.
  static double compute_time_s(const ShapeStage& stage, double over_s) noexcept;

  // The shape at the time of the last step. RT: no.
  std::vector<Vec3> vertices() const;

 private:
  StreamedMethod(std::unique_ptr<ForceMethod> method, std::unique_ptr<ShapeStager> stager);

  std::unique_ptr<ShapeStager> stager_;
  std::unique_ptr<RidingProxy<StreamedGeometry>> riding_;
};

}  // namespace hapton
