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
  // The sample of the step before once more, with another device point, which takes the place of the other: damping sees the motion since
  // the sample before that one. Only methods that are parts of another one get it (CommonProxy).
  bool is_correction = false;
  std::uint32_t buttons = 0;  // of the stylus that are down, a bit each (button_bit); of use to what can be carved only
  // Where programs have moved objects, by their number among those with a TouchObject::command_pivot: X_SO at that time. Empty: at rest.
  std::span<const Pose> commanded = {};
  const TouchInput* touch = nullptr;  // the same in frame W, with the stylus; of use to methods of plug-ins only. Null: not known
};

// The result of that sample.
struct MethodOutput {
  Vec3 force_n = Vec3::Zero();  // acts on the device, frame S
  Vec3 p_SP = Vec3::Zero();     // proxy: where the probe is drawn; the device point itself in free space
  bool contact = false;         // a surface (smooth: or its layer) holds the probe: a force, unless damping takes all of it
  // In contact: the object touched, an index into TouchScene::objects; of several, the one with the largest force. -1: none, or a
  // method that sums over objects (smooth, in the layer outside the surface).
  int object = -1;
};

// What carved bodies add to force and position of the proxy of a step. Frame: S.
struct BodyPush {
  Vec3 force_n = Vec3::Zero();
  Vec3 extension_m = Vec3::Zero();
};

// A method that turns device samples into forces. It keeps its own state between samples (the proxy, the last position).
// RT: step, reset, held_at, resume, carried_from and set_materials yes (no heap, lock, system call, log or throw); everything else set-up
// only.
class ForceMethod {
 public:
  virtual ~ForceMethod() = default;

  // The force for one sample. A sample that is not finite gives zero force and changes nothing else.
  virtual MethodOutput step(const MethodInput& input) noexcept = 0;

  // Forgets all contact and puts the probe at p_SD in free space.
  virtual void reset(const Vec3& p_SD) noexcept = 0;

  // To continue with another instance of the method, on a part of the same surface in the same local frame (TouchScene::part_of).
  // held_at: the position of a proxy that a surface holds, also at zero force; none: the proxy is free, at the device. resume: forgets
  // all contact and puts the proxy exactly there, on its present side of the surface, however near; the next step moves it from there
  // towards the device. A method without a proxy is reset.
  virtual std::optional<Vec3> held_at() const noexcept { return std::nullopt; }
  virtual void resume(const Vec3& p_SP) noexcept { reset(p_SP); }

  // If the last step reached its work limit: how far along the device's path it got. The next step follows the rest first. None: it was
  // finished.
  virtual std::optional<Vec3> carried_from() const noexcept { return std::nullopt; }

  // Only the materials have changed: proxy and contact stay, and the next step uses the new ones. Pre: one for each object of the scene,
  // with the stiffness from couple_material, two_sided as before. Threads: as step.
  virtual void set_materials(std::span<const Material> materials) noexcept = 0;

  // The material of each object, if the method renders neither its damping nor its friction, so that TouchStep adds them as effects of the
  // surface. Empty: the method renders them itself. RT: yes.
  virtual std::span<const Material> unrendered_drag() const noexcept { return {}; }

  // Of the last step, if MethodOutput::object is another object: effects of its surface do not act on this part. RT: yes.
  virtual BodyPush body_push() const noexcept { return {}; }

  // The bodies of material that its steps carve; null: the scene has none. exchange_sculpture: goes on with the bodies of `other` and gives
  // it its own, if they are the same at rest; otherwise it does nothing.
  virtual const Sculpture* sculpture() const noexcept { return nullptr; }
  virtual void exchange_sculpture(ForceMethod& /*other*/) noexcept {}
  // Goes on with the shapes of `other`, from which carves were undone, and gives it its own. newest: the serial of that undo. A probe that
  // is then inside the material has no force until it has left it. False: `other` has other bodies, and nothing has changed.
  virtual bool restore_sculpture(Sculpture& /*other*/, std::uint32_t /*newest*/) noexcept { return false; }
  // Makes a carve again that such steps made elsewhere, as the next one in their order. object: of the scene. False: it changes nothing
  // here, so it is not of these bodies in their present shape.
  virtual bool repeat_carve(int /*object*/, const Carve& /*carve*/) noexcept { return false; }

  // Where an object that deforms was touched in the last step, for effects of its surface; the step's `object` is of the scene, and the
  // frame that in which the object is at rest. None: it was not touched, or keeps its shape. RT: yes.
  virtual std::optional<SurfacePlace> find_place(int /*object*/) const noexcept { return std::nullopt; }

  // What feels an object that a program deforms (TouchObject::stream_reach_m). object: of the scene. Null: it is none, or the method does
  // not feel it. It lives as long as this.
  virtual StreamedMethod* find_streamed(int /*object*/) noexcept { return nullptr; }

  // The objects for which there is one, in ascending order. RT: no.
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
