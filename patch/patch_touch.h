#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/force/common_proxy.h"
#include "core/force/touch_step.h"
#include "core/math/types.h"
#include "patch/device_path.h"
#include "patch/patch_shaper.h"

namespace hapton {

// Materials by the scene's number of the object, ascending: of the objects that got another one since the first parts came.
struct PatchMaterials {
  std::vector<std::pair<int, Material>> objects;
  std::uint32_t version = 0;  // counts up
};

// A piece of a body of the scene on which forces can be computed: within radius_m of its centre no triangle is missing. Frame: that of
// the body, which is S if it stands still. Units: m.
struct Patch {
  std::unique_ptr<TouchStep> step;  // null: there is no triangle
  std::vector<int> objects = {};    // the scene's number of each object in the patch
  Vec3 p_SC = Vec3::Zero();
  double radius_m = 0.0;
  double lift_m = 0.0;           // distance from the surface at which a proxy that no patch has held starts: above the rounding of the grid
  std::uint32_t generation = 0;  // of its scene
  std::vector<Material> materials = {};  // of `objects`; use_materials() changes them here
  std::vector<Material> shared = {};     // the same as CommonProxy needs them (shared_material); empty: as materials
  std::uint32_t material_version = 0;    // PatchMaterials::version that these materials have
  bool is_shared = false;                // the step uses `shared`
  bool deforms = false;                  // as a function of the scene time; then the patch is the whole body
  StreamedMethod* streamed = nullptr;    // the method of the step, if programs deform the body
  std::uint32_t number = 0;              // ... then the number that PatchShape::patch names
  bool is_path_incomplete = false;       // parts of the scene between the last proxy within a patch and the hand are missing

  void set_materials() noexcept { step->set_materials(is_shared && !shared.empty() ? shared : materials); }
};

// One step on a patch.
struct PatchOutput {
  Vec3 force_n = Vec3::Zero();          // frame W
  Vec3 visual_offset_m = Vec3::Zero();  // frame W: proxy minus device point
  bool contact = false;
  bool is_handed_over = false;       // another patch, or the edge of one, began with this step: the force may differ ...
  Vec3 difference_n = Vec3::Zero();  // ... or by just this much, where the patch before could tell it for this sample too. Frame W
  bool is_beyond = false;            // past the edge of what is known
  int object = -1;                   // number of the touched object in the scene; -1: none, or beyond
  // Frame W: proxy minus device point, if the probe is drawn elsewhere, as a needle in layers is. None: it is visual_offset_m.
  std::optional<Vec3> held_offset_m = {};
};

// A ball around the last proxy within a patch and all positions of the device since: what a patch has to cover so that the proxy can follow
// the device. Frame: S, or that of the body.
struct PathBall {
  Vec3 p_SC = Vec3::Zero();
  double radius_m = 0.0;
};

// Where the device is, for the maker of the next patch. Frame: S, or that of the body.
struct PatchHandState {
  Vec3 p_SD = Vec3::Zero();
  std::int64_t time_ns = 0;
  bool is_beyond = false;  // past the edge of its patch: the next one has to cover `path`
  PathBall path;
  std::int64_t scene_time_ns = 0;  // scene time of the sample
};

// Computes the force of a scene from patches of it, one after the other. The force is that of the whole scene as long as everything that
// the step can meet lies within the patch: |device - centre| + |proxy - device| + |motion| is less than the radius of the patch.
//
// A new patch takes over at the proxy: its step starts there and moves to the device. So the path of the proxy has no gap, and contact
// continues with the same surface, because both patches have the same triangles on the same grid. A proxy that no patch has held is lifted
// off the surface first, along the force. The old and the new patch compute that sample, so that the effect of the hand's motion does not
// count as a difference between them.
//
// Past the edge of a patch the positions of the device are stored, and the plane of the last contact acts as the surface. Its force has the
// stiffness of the surface and damping of its own, and is at most kMaxBeyondForceRatio times the last force within the patch, without the
// surface's damping. Without contact there is no force past the edge. When a patch reaches the stored positions, the proxy follows them,
// kMaxFollowed in each step, until it has caught up: it is then where the whole scene would have it. A patch with is_path_incomplete does
// not wait for that: in contact it takes over from a point above the plane, the higher the farther the hand went, and contact continues
// with the surface met first from there. A hand that was free for kBeyondS past the edge starts again where it is.
//
// Frames: W and S as named; for a body that moves (PatchChain), S and its frame in their place. Units: SI. RT: yes. Threads: one.
class PatchTouch {
 public:
  static constexpr int kMaxFollowed = 32;              // stored positions in one step: those of a second at 1 kHz in 32 steps
  static constexpr double kBeyondS = 5.0;              // s, see above
  static constexpr double kMaxBeyondForceRatio = 2.0;  // largest force past the edge, over the last one within the patch
  static constexpr double kBeyondDampingS = 0.005;     // damping of the plane over its stiffness
  static constexpr double kRisePerDistance = 0.25;     // height above the plane over the distance along it since the edge, ...
  static constexpr double kMinRiseInDepths = 2.0;      // ... and at least this many times the last penetration within the patch
  static constexpr double kMaxRoomShare = 0.9;         // share of a patch's room above the hand in which a proxy may start

  struct Counts {
    std::uint64_t steps = 0;
    std::uint64_t contact_steps = 0;
    std::uint64_t followed = 0;      // ... made late, for stored positions that were past the edge of the patch at the time
    std::uint64_t handed_over = 0;   // patches that took over
    std::uint64_t beyond = 0;        // times that the hand came past the edge
    std::uint64_t beyond_steps = 0;  // steps past the edge
    std::uint64_t raised = 0;        // patches that took over from above the plane
    std::uint64_t begun_anew = 0;    // times that a free hand stayed past the edge for longer than kBeyondS
    std::uint64_t late_moves = 0;    // of PatchChain: moves of objects that came too late to go as announced
    std::uint64_t shapes = 0;        // stages of objects that programs deform
    std::uint64_t late_shapes = 0;   // ... of them, those that came too late to go as announced
  };

  // Offers a patch: it takes over with the first step that lies within it. Returns the one that was offered before and has not.
  std::unique_ptr<Patch> offer(std::unique_ptr<Patch> patch) noexcept;
  // Returns the replaced patch, so that a thread that is not real-time can free it. No other patch takes over before this is called.
  std::unique_ptr<Patch> take_retired() noexcept;
  // Forgets contact; the next step starts as start_at says, or at the device.
  void forget() noexcept;
  // Only patches of this generation are used from now on. If the generation is new, they start where the probe was.
  void set_generation(std::uint32_t generation) noexcept;
  // Says where the proxy of a contact, or the free device, was before the first patch, and how long ago: from there the proxy follows the
  // positions that the device has had since. outward: direction of the force, unit; zero: free.
  void start_at(const Vec3& p_SP, const Vec3& outward, double age_s = 0.0) noexcept;
  // Sets the proxy to exactly p_SP, which is on its side of the surface, to continue from there: its earlier path does not count.
  void go_on_from(const Vec3& p_SP) noexcept;
  // Takes the next motion of the surface of a patch that is here. One that comes late reaches the same shape at the same time, or as soon
  // after it as kMaxSurfaceSpeed allows. False: it has to wait, because its patch is not here yet or too many stages wait. True: `shape`
  // then holds what is no longer used, to be destroyed elsewhere.
  bool take(PatchShape& shape) noexcept;
  // Uses other materials from the next step on, in which is_handed_over is set if the patch has one of their objects.
  void use_materials(const PatchMaterials& materials) noexcept;
  // True once a patch has reached the hand since the start. Until then the force has to come from elsewhere.
  bool has_arrived() const noexcept { return has_arrived_; }

  // Whether other bodies hold the proxy as well from the next step on: then static friction is dynamic friction (CommonProxy).
  void set_shared(bool is_shared) noexcept;

  // input.is_correction: this is the sample of the last step again, with another device point, as in MethodInput.
  // None: no patch has reached the hand since the start or the last new start; or the sample is not finite, or so far away that its
  // rounding exceeds a patch's lift (10^9 sizes of the scene): such a sample changes nothing.
  std::optional<PatchOutput> step(const TouchInput& input) noexcept;

  // The same as ForceMethod::carried_from. Frame: S.
  std::optional<Vec3> carried_from() const noexcept;

  const Counts& counts() const noexcept { return counts_; }
  bool is_placed() const noexcept { return is_placed_; }
  // The proxy after the last step within a patch. Frame: S, as for device() and outward().
  const Vec3& proxy() const noexcept { return p_SP_; }
  const Vec3& device() const noexcept { return newest_p_SD_; }  // in the last step
  bool is_beyond() const noexcept { return is_beyond_; }
  // The stiffness of the materials of the patch, or of the plane past its edge.
  StiffnessRange stiffness() const noexcept;
  // True if no surface of the patch has dynamic friction; false past its edge.
  bool is_frictionless() const noexcept;
  // The damping of an object of the scene, N s/m; 0 if the patch does not have the object, and past its edge.
  double damping_of(int object) const noexcept;
  // The stiffness of an object of the scene; if the patch does not have the object, and past its edge, the largest of stiffness().
  double stiffness_of(int object) const noexcept;
  // Where an object of the scene that deforms was touched: as ForceMethod::find_place.
  std::optional<SurfacePlace> find_place(int object) const noexcept;
  const Vec3& outward() const noexcept { return outward_S_; }  // from the device to the proxy, unit; zero: no contact
  // Where the hand is, for the maker of the next patch.
  PatchHandState hand_at(const Vec3& p_SD, std::int64_t time_ns) const noexcept;

 private:
  PathBall path_ball() const noexcept;
  bool is_precise_enough(const Vec3& p_SD) const noexcept;
  bool reaches(const Patch& patch, const Vec3& p_SD) const noexcept;
  bool reaches_next() const noexcept { return patch_ != nullptr && !path_.empty() && reaches(*patch_, path_.front().p_SD); }
  void take_offered(const DevicePath::Place& newest) noexcept;
  bool rise_over(const Patch& patch, const Vec3& p_SD) noexcept;
  PatchOutput step_patch(const TouchInput& input, const Vec3& p_SD, bool could_go_on) noexcept;
  std::optional<PatchOutput> correct(const TouchInput& input, const Vec3& p_SD) noexcept;
  void update_shared(Patch& patch) noexcept;
  const Material* find_material(int object) const noexcept;
  std::optional<PatchOutput> step_plane(const TouchInput& input, const Vec3& p_SD, const Vec3& velocity) noexcept;
  void hand_over(const TouchInput& input) noexcept;
  Vec3 step_retired(const TouchInput& input) noexcept;
  double undamped_force_n(const TouchOutput& touch_output, double depth) const noexcept;
  static bool tune(Patch& patch, const PatchMaterials& materials) noexcept;

  std::unique_ptr<Patch> patch_;
  std::unique_ptr<Patch> offered_;
  std::unique_ptr<Patch> retired_;
  std::uint32_t generation_ = 0;
  bool is_placed_ = false;       // the proxy is known
  bool has_taken_over_ = false;  // patch_ holds the proxy; else it has to be handed over
  bool is_on_grid_ = false;      // a patch held the proxy last
  bool has_arrived_ = false;
  Vec3 p_SP_ = Vec3::Zero();        // the proxy, when it was last within a patch
  Vec3 outward_S_ = Vec3::Zero();   // direction of its force, unit; zero: free
  double stiffness_n_per_m_ = 0.0;  // ... stiffness: this force over the penetration
  double force_n_ = 0.0;            // ... its magnitude, without damping
  Vec3 last_p_SD_ = Vec3::Zero();   // the device in the last step within a patch, or where that step ran out of work
  Vec3 newest_p_SD_ = Vec3::Zero();
  Vec3 previous_p_SD_ = Vec3::Zero();  // the device before this sample
  bool is_shared_ = false;
  DevicePath path_;
  bool is_beyond_ = false;
  bool is_retuned_ = false;  // there are other materials since the last step
  double beyond_time_s_ = 0.0;
  Counts counts_;
};

}  // namespace hapton
