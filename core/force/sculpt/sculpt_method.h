#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/force/common_proxy.h"
#include "core/force/force_method.h"
#include "core/force/scene_parts.h"
#include "core/force/sculpt/carving_ball.h"
#include "core/sculpt/sculpture.h"

namespace hapton {

// The force method of a scene with objects that can be carved (TouchObject::sculpt), here called bodies. Each body is felt with a ball
// (CarvingBall), whatever the probe of the method is; the other objects are felt as in a scene without bodies (SceneParts). All of them
// have one proxy (CommonProxy). Methods that cannot feel a sample twice (smooth, sweep) are connected with the bodies in series: the method
// first, then the bodies in the order of the scene.
//
// Frame: S. Units: SI. RT: step, reset, resume, held_at, set_materials, exchange_sculpture and restore_sculpture yes. Threads: as
// ForceMethod.
class SculptMethod final : public ForceMethod {
 public:
  // make: makes the method of the other objects. has_proxy: MethodOutput::p_SP of that method is a proxy, and the method knows
  // MethodInput::is_correction. Pre: a body in the scene; materials are coupled (couple_material). Error: that of SceneParts::make; a body
  // whose mesh is not closed, or whose voxels are too small or not positive.
  static Result<std::unique_ptr<ForceMethod>> make(SceneParts::Make make, bool has_proxy, const MethodSettings& settings,
                                                   const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::optional<Vec3> held_at() const noexcept override { return held_at_; }
  void resume(const Vec3& p_SP) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::span<const Material> unrendered_drag() const noexcept override { return unrendered_drag_; }
  BodyPush body_push() const noexcept override { return body_push_; }
  const Sculpture* sculpture() const noexcept override { return sculpture_.get(); }
  void exchange_sculpture(ForceMethod& other) noexcept override;
  bool restore_sculpture(Sculpture& other, std::uint32_t undo_serial) noexcept override;
  bool repeat_carve(int object, const Carve& carve) noexcept override;
  StreamedMethod* find_streamed(int object) noexcept override { return others_.find_streamed(object); }
  std::optional<SurfacePlace> find_place(int object) const noexcept override { return others_.find_place(object); }
  std::vector<int> list_streamed() const override { return others_.list_streamed(); }
  bool prepare() override { return others_.prepare(); }
  std::string describe() const override;

 private:
  struct Body {
    CarvingBall ball;
    Material material;
    Vec3 extension_m = Vec3::Zero();         // proxy minus goal in the last step, for damping
    Vec3 extension_before_m = Vec3::Zero();  // the same in the sample before
  };

  class Parts;  // the parts for the common proxy in one sample: the other objects, then the bodies

  SculptMethod(SceneParts others, std::size_t bodies, bool has_proxy);
  void update_unrendered_drag() noexcept;
  bool is_body(int object) const noexcept;
  bool cuts(std::size_t body, const MethodInput& input) const noexcept;
  MethodOutput feel(std::size_t body, const MethodInput& input, const Vec3& goal, const FeltParts::Turn& turn) noexcept;

  SceneParts others_;
  std::vector<Material>
      unrendered_drag_;       // unrendered_drag(): by object of the scene, without drag for the bodies; empty: the methods render all
  std::vector<Body> bodies_;  // in the order of Sculpture::bodies()
  CommonProxy proxy_;
  std::uint32_t carve_buttons_ = 0;  // the carving buttons of all bodies
  std::unique_ptr<Sculpture> sculpture_ = std::make_unique<Sculpture>();
  BodyPush body_push_;
  std::optional<Vec3> held_at_;  // as held_at() returns it
  bool has_begun_ = false;       // there was a step or a reset
};

}  // namespace hapton
