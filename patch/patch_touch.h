#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/force/touch_step.h"
#include "core/math/types.h"
#include "patch/device_path.h"

namespace hapton {

// A piece of the scene, ready to be felt: within radius_m of the centre no triangle is missing. Frame: S. Units: m.
struct Patch {
  std::unique_ptr<TouchStep> step;  // null: there is no triangle
  std::vector<int> objects = {};    // the scene's number of each object of it
  Vec3 p_SC = Vec3::Zero();
  double radius_m = 0.0;
  double lift_m = 0.0;           // how far off the surface a proxy starts that no patch has held: above what the grid rounds
  std::uint32_t generation = 0;  // of the scene that it is of
  bool is_way_unknown = false;   // when it was made, not all of the scene between the last proxy within and the hand had come
};

// One step on a patch.
struct PatchOutput {
  Vec3 force_n = Vec3::Zero();          // frame W
  Vec3 visual_offset_m = Vec3::Zero();  // frame W: proxy minus device point
  bool contact = false;
  bool is_handed_over = false;       // another patch, or the edge of one, began with this step: the force may differ ...
  Vec3 difference_n = Vec3::Zero();  // ... or by just this much, where the patch before could tell it for this sample too. Frame W
  bool is_beyond = false;            // past the edge of what is known
  int object = -1;                   // touched, of the scene's objects; -1: none, or beyond
};

// What a patch has to reach for the hand to be caught up with: a ball about the proxy, last within, and the places since. Frame S.
struct PatchWay {
  Vec3 p_SC = Vec3::Zero();
  double radius_m = 0.0;
};

// Where the device is, for whoever makes the next patch. Frame S.
struct PatchHand {
  Vec3 p_SD = Vec3::Zero();
  std::int64_t time_ns = 0;
  bool is_beyond = false;  // past the edge: a patch has to reach over ...
  PatchWay way;            // ... this
};

// Feels a scene by patches of it, one after the other. The force is that of the whole scene as long as all that the step can meet lies
// within the patch: device and proxy move within |device - centre| + |proxy - device| + |motion| of its centre.
//
// Another patch takes over where the proxy is: its step starts there and goes from there to the device. So the path of the proxy has no
// gap, and the surface that was felt is felt: both have the same triangles on the same grid. A proxy that no patch has held is lifted off
// first, along the force. Both patches are stepped with that sample, so that what the hand's motion changes is not taken for a difference
// between them.
//
// Past the edge the places of the device are kept, and the plane of the last contact holds: its force is that of the surface's stiffness,
// damped, and never larger than kMostBeyond times the last force within. Without contact there is no force past the edge. Once a patch
// reaches there, the proxy follows the device from place to place, kMostFollowed a step, until it has caught up: it comes to where the
// whole scene has it, whatever lay on the way. A patch with is_way_unknown need not wait for that: in contact it takes over from above the
// plane, by a share of the way that the hand went past the edge, and the surface that is met first from there is felt. A hand that was free
// for kBeyondS starts again where it is.
//
// Frames: W and S as named. Units: SI. RT: all. Threads: one.
class PatchTouch {
 public:
  static constexpr int kMostFollowed = 32;  // places a step: a second at 1 kHz within 32 steps
  static constexpr double kBeyondS = 5.0;
  static constexpr double kMostBeyond = 2.0;
  static constexpr double kBeyondDampingS = 0.005;  // damping of that plane, over its stiffness
  static constexpr double kLeastRise = 2.0;         // ... at least, of the last penetration within
  static constexpr double kMostRoom = 0.9;          // of a patch's room, for a proxy that starts above it
  static constexpr double kRise = 0.25;             // how far above the plane, for the way past the edge

  struct Counts {
    std::uint64_t steps = 0;
    std::uint64_t contact_steps = 0;
    std::uint64_t followed = 0;      // ... that were late: places of the device past the edge of the patch of then
    std::uint64_t handed_over = 0;   // patches that took over
    std::uint64_t beyond = 0;        // times that the hand came past the edge
    std::uint64_t beyond_steps = 0;  // steps there
    std::uint64_t raised = 0;        // patches that took over from above the plane
    std::uint64_t begun_anew = 0;    // times that the hand stayed there, free, for too long
  };

  // Offers a patch: it takes over with the first step that lies within it. Returns the one that was offered before and did not.
  std::unique_ptr<Patch> offer(std::unique_ptr<Patch> patch) noexcept;
  // The patch that was taken over from, to be freed by whoever may. No other takes over before it is taken.
  std::unique_ptr<Patch> take_retired() noexcept;
  // Forgets contact; the next step starts where it is told to, or at the device.
  void forget() noexcept;
  // Only patches of this generation count from now on; where it is another one than before, they start where the probe was.
  void set_generation(std::uint32_t generation) noexcept;
  // Where contact rested, or the device was free, before the first patch, and how long ago: from there the proxy follows the places of the
  // device since. outward: unit, of the force; zero: free.
  void start_at(const Vec3& p_SP, const Vec3& outward, double age_s = 0.0) noexcept;
  // A patch has reached the hand since the start. Until then the force has to come from elsewhere.
  bool has_arrived() const noexcept { return has_arrived_; }

  // None: no patch has reached the hand yet, since the start or since it started again; or a sample that is not finite, or so far off that
  // its rounding is larger than a patch's lift (10^9 sizes of the scene): it changes nothing.
  std::optional<PatchOutput> step(const TouchInput& input) noexcept;

  // See ForceMethod. Frame: S.
  std::optional<Vec3> carried_from() const noexcept;

  const Counts& counts() const noexcept { return counts_; }
  bool is_placed() const noexcept { return is_placed_; }
  // Where the hand is, for whoever makes the next patch.
  PatchHand hand_at(const Vec3& p_SD, std::int64_t time_ns) const noexcept;

 private:
  PatchWay way() const noexcept;
  bool is_place(const Vec3& p_SD) const noexcept;
  bool reaches(const Patch& patch, const Vec3& p_SD) const noexcept;
  bool reaches_next() const noexcept { return patch_ != nullptr && !path_.empty() && reaches(*patch_, path_.front().p_SD); }
  void take_offered(const DevicePath::Place& newest) noexcept;
  bool rise_over(const Patch& patch, const Vec3& p_SD) noexcept;
  PatchOutput step_patch(const TouchInput& input, const Vec3& p_SD, bool could_go_on) noexcept;
  std::optional<PatchOutput> step_plane(const TouchInput& input, const Vec3& p_SD, const Vec3& velocity) noexcept;
  void hand_over(const TouchInput& input) noexcept;
  Vec3 step_retired(const TouchInput& input) noexcept;

  std::unique_ptr<Patch> patch_;
  std::unique_ptr<Patch> offered_;
  std::unique_ptr<Patch> retired_;
  std::uint32_t generation_ = 0;
  bool is_placed_ = false;   // the proxy is known
  bool is_over_ = false;     // patch_ holds the proxy; else it has to be handed over
  bool is_on_grid_ = false;  // it was a patch that had it last
  bool has_arrived_ = false;
  Vec3 p_SP_ = Vec3::Zero();        // proxy, last within
  Vec3 outward_S_ = Vec3::Zero();   // unit, of its force; zero: free
  double stiffness_n_per_m_ = 0.0;  // ... of force and penetration
  double force_n_ = 0.0;            // ... its magnitude
  Vec3 last_p_SD_ = Vec3::Zero();   // of the last step within, or where it ran out of work
  Vec3 newest_p_SD_ = Vec3::Zero();
  DevicePath path_;
  bool is_beyond_ = false;
  double beyond_s_ = 0.0;
  Counts counts_;
};

}  // namespace hapton
