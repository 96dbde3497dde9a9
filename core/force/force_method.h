#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/effects/surface_place.h"
#include "core/force/touch_scene.h"
#include "core/math/types.h"
#include "core/sculpt/sculpture.h"

namespace hapton {

class StreamedMethod;
struct TouchInput;

// One device sample, in the static scene's frame.
struct MethodInput {
  Vec3 p_SD = Vec3::Zero();  // device point, m
  double dt_s = 1e-3;        // time since the sample before
  double time_s = 0.0;       // scene time, for objects that move or deform
  // The last sample again, with a corrected device point that replaces the one of the last step: damping uses the motion since the sample
  // before the last one. Only methods that feel a part of a scene for another method get it (CommonProxy).
  bool is_correction = false;
  std::uint32_t buttons = 0;  // pressed buttons of the stylus, a bit each (button_bit); used by objects that can be carved only
  // X_SO at time_s of each object that programs may move (TouchObject::command_pivot), in the order of the scene. Empty: all are at rest.
  std::span<const Pose> commanded = {};
  const TouchInput* touch = nullptr;  // the sample in frame W, with the orientation of the stylus; for plug-ins only. Null: not known
};

// The result of that sample.
struct MethodOutput {
  Vec3 force_n = Vec3::Zero();  // acts on the device, frame S
  Vec3 p_SP = Vec3::Zero();     // proxy: where the probe is drawn; the device point itself in free space
  bool contact = false;         // a surface (smooth: or its layer) holds the probe; its force is zero only if damping cancels it
  // In contact: the object touched, an index into TouchScene::objects; of several, the one with the largest force. -1: none, or a
  // method that sums over objects (smooth, in the layer outside the surface).
  int object = -1;
};

// The part of a step's force, and of its proxy's position, that is due to objects that can be carved. Frame: S.
struct BodyPush {
  Vec3 force_n = Vec3::Zero();
  Vec3 extension_m = Vec3::Zero();
};

// A method that turns device samples into forces. It keeps its own state between samples (the proxy, the last position).
// RT: step, reset, held_at, resume, carried_from, set_materials, find_streamed and the sculpture functions yes (no heap, lock, system call,
// log or throw); the others as stated, or else set-up only.
class ForceMethod {
 public:
  virtual ~ForceMethod() = default;

  // The force for one sample. A sample that is not finite gives zero force and changes nothing else.
  virtual MethodOutput step(const MethodInput& input) noexcept = 0;

  // Forgets all contact and puts the probe at p_SD in free space.
  virtual void reset(const Vec3& p_SD) noexcept = 0;

  // To go on with another instance of the method, on a part of the same surface in the same local frame (TouchScene::part_of). held_at: the
  // position of a proxy that a surface holds, also at zero force; none: the proxy is free, at the device, or the method has none. resume:
  // forgets all contact and puts the proxy exactly there, on its present side of the surface, however near (a sphere less than a contact
  // offset from a triangle is first moved off it); the next step moves it towards the device. A method without a proxy is reset.
  virtual std::optional<Vec3> held_at() const noexcept { return std::nullopt; }
  virtual void resume(const Vec3& p_SP) noexcept { reset(p_SP); }

  // If the last step used up its work: the point of the device's path up to which it got. The next step first follows the rest of it.
  // None: the step was completed.
  virtual std::optional<Vec3> carried_from() const noexcept { return std::nullopt; }

  // Only the materials have changed: proxy and contact stay, and the next step uses the new ones. Pre: one for each object of the scene,
  // with the stiffness from couple_material, two_sided as before. Threads: as step.
  virtual void set_materials(std::span<const Material> materials) noexcept = 0;

  // The material of each object, if the method renders neither its damping nor its friction, so that TouchStep adds them as effects of the
  // surface. Empty: the method renders them itself. RT: yes.
  virtual std::span<const Material> unrendered_drag() const noexcept { return {}; }

  // What carved objects added to the last step, if MethodOutput::object is another one: the effects of its surface leave that out. RT: yes.
  virtual BodyPush body_push() const noexcept { return {}; }

  // The objects that can be carved, with what the steps have carved; null: the scene has none. exchange_sculpture: exchanges them with
  // those of `other`, if both had the same ones before any carve; otherwise it does nothing.
  virtual const Sculpture* sculpture() const noexcept { return nullptr; }
  virtual void exchange_sculpture(ForceMethod& /*other*/) noexcept {}
  // Exchanges the shapes with `other`, in which carves were undone. undo_serial: that of this undo. A probe that is then inside
  // the material has no force until it has left it. False: `other` is of other objects, and nothing has changed.
  virtual bool restore_sculpture(Sculpture& /*other*/, std::uint32_t /*undo_serial*/) noexcept { return false; }
  // Repeats a carve that the steps of another instance made, as the next one in their order. object: its index in the scene. False: nothing
  // was removed: it cannot be carved, no further carve is possible, or the carve removes nothing from its present shape.
  virtual bool repeat_carve(int /*object*/, const Carve& /*carve*/) noexcept { return false; }

  // Where an object that deforms was touched in the last step, for the effects of its surface. object: its index in the scene. Frame: that
  // in which the object's mesh is at rest. None: it was not touched, or does not deform. RT: yes.
  virtual std::optional<SurfacePlace> find_place(int /*object*/) const noexcept { return std::nullopt; }

  // The part of the method that feels an object that a program deforms (TouchObject::stream_reach_m). object: its index in the scene. Null:
  // no program deforms it, or the method cannot feel it. It lives as long as this method.
  virtual StreamedMethod* find_streamed(int /*object*/) noexcept { return nullptr; }

  // The indices of all objects for which find_streamed returns a method, in ascending order. RT: no.
  virtual std::vector<int> list_streamed() const { return {}; }

  // The slow task: does one piece of work that steps have requested, such as building the structures of an object that the probe
  // approaches. Returns true if there was any. RT: no. Threads: may run beside step and reset, in one thread at a time.
  virtual bool prepare() { return false; }

  // A few lines for users: what was built, what was skipped, counters.
  virtual std::string describe() const = 0;
};

// The settings of all methods. Each comment starts with the methods that read the field.
struct MethodSettings {
  static constexpr double kDefaultOffsetM = 0.0005 * 0.0254;
  std::string name = "proxy";                       // all: proxy | smooth | sweep | reference
  std::array<int, 3> grid_division = {32, 32, 32};  // sweep: cells along x, y, z (memo 4.2.2)
  double offset_m = kDefaultOffsetM;                // sweep: offset vector's length, 0.0005 in (memo 4.2.2)
  int set_size = 64;                                // smooth: triangles in the local set, 16..256
  double smooth_radius_m = 0.0;                     // smooth: RADIUS of Algorithm 1; 0: from the data
  double smooth_layer = 0.0;                        // smooth: share of RADIUS over which the force builds up outside the surface, 0..1
  int hull_directions = 14;                         // smooth: number of directions of its Fixed Direction Hulls: 6, 14, 18 or 26
  double crease_deg = 40.0;        // smooth, proxy with shading: edges with a larger angle between the faces' normals stay sharp, 0..180
  double simplify_m = 0.0;         // smooth: largest distance by which merging small triangles may move a vertex; 0: no merging
  bool build_on_approach = false;  // proxy: prepare() builds an object's structures when the probe first comes near
  double shading = 0.0;            // proxy: weight of the interpolated smooth normals in the force direction: 0 (face normals) to 1
  double probe_radius_m = 0.0;     // proxy, reference: 0 for a point probe
  double coupling_n_per_m = 0.0;   // all: virtual coupling (virtual_coupling.h), in series with every surface; 0: none
  int reference_substeps = 64;     // reference: sub-steps of the first pass over a step; doubled until the force settles
  int reference_substep_limit = 1024;  // reference: the doubling ends here and the step counts as unsettled
};

// Builds the named method for the scene. RT: set-up only. Error: unknown name, impossible setting, empty scene, an object without
// triangles.
Result<std::unique_ptr<ForceMethod>> make_method(const MethodSettings& settings, const TouchScene& scene);

// The known names, "sweep, ...", for help texts. RT: set-up only.
std::string method_names();
bool is_method_name(std::string_view name);
// Whether the probe of that method may be a sphere (MethodSettings::probe_radius_m).
bool supports_spheres(std::string_view name);

}  // namespace hapton
