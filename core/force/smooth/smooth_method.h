#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/force_method.h"
#include "core/force/smooth/local_set.h"
#include "core/force/smooth/smooth_force.h"
#include "core/force/smooth/smooth_scene.h"

namespace hapton {

// What happened since it was built.
struct SmoothCounters {
  std::uint64_t steps = 0;
  std::uint64_t skipped = 0;      // the probe was where the set knows that nothing is
  std::uint64_t selections = 0;   // sets this task had to select itself
  std::uint64_t offered = 0;      // sets taken over from the slow task
  std::uint64_t late = 0;         // of the selections: a slow task was at work, but its set did not reach far enough
  std::uint64_t overflows = 0;    // looks that not even a fresh set was large enough for, answered by the tree
  std::uint64_t entries = 0;      // the probe went through the surface
  std::uint64_t releases = 0;     // and came out again
  std::uint64_t astray = 0;       // no intersection on the way outward: the VCP went to the surface's nearest point
  std::uint64_t hidden = 0;       // VCPs removed under another triangle, fig. 3
  std::uint64_t crowded_out = 0;  // VCPs beyond the capacity of one step
};

// fdh-rendering.txt whole: the fast task computes force on a small set of triangles near the probe (Algorithm 1: smooth normals, hidden
// VCPs removed), and a probe that has gone through the surface is tracked by its VCP (fig. 4), so that it keeps feeling the outside.
// The force is a function of the triangles within RADIUS of the probe or its VCP and of where both were: two sets that are complete that
// far give the same force to the last bit, so exchanging sets cannot be felt. A step never trusts a set beyond its radius: it then selects
// one itself, and where none is large enough it asks the tree; both are counted.
// f: outside the surface a spring over `layer` (0: contact begins at the surface, as in every other method); inside, that spring's full
// force and the spring between probe and VCP. Material: stiffness and two_sided; friction and damping are not this method's.
// Decisions where the paper leaves a choice: docs/decisions/0003-fdh-smooth.md.
// Frame S. Threads: one; prepare in a second one, except while vertices move. scene() may be read by any while no vertices move.
// RT: step, reset, request, offer yes; bounded time while counters().overflows stands still.
class SmoothMethod final : public ForceMethod {
 public:
  struct Settings {
    std::uint32_t set_size = 64;  // triangles, 16..256
    double radius_m = 0.0;        // RADIUS; 0: from the data, see make_radius in the .cpp
    double layer = 0.0;           // of RADIUS: where f begins outside the surface, 0..1
    SmoothSceneSettings scene;
  };

  // RT: set-up only. Error: an impossible setting; as SmoothScene::build.
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);
  static Result<std::unique_ptr<SmoothMethod>> make_with(const Settings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::string describe() const override;

  // The slow task: selects the set that the fast one asked for last, if it has asked, and hands it over.
  bool prepare() override;

  // The same by hand, for a slow task elsewhere: it selects around request() with scene().select(request, set_size(), set) at its own pace.
  // offer takes the set over, unless it is worth less than the one at hand; from the first one on, selections count as late.
  LocalSetRequest request() const noexcept;
  void offer(const LocalSet& set) noexcept;
  const SmoothScene& scene() const { return *scene_; }
  std::uint32_t set_size() const { return set_size_; }

  // One object's vertices have moved or changed shape since the last step, by its mesh's order. The VCP rides on its triangle; a surface
  // that has swept over the probe has it inside. RT: no (linear in the object). Error: as SmoothScene::move_vertices.
  Result<void> move_vertices(std::uint32_t object, std::span<const Vec3> vertices);

  const SmoothCounters& counters() const { return counters_; }
  double radius_m() const { return radius_; }
  double layer_m() const { return layer_; }  // where f begins outside the surface
  bool is_inside() const { return inside_; }
  const LocalSet& local_set() const { return set_; }

  // Every look goes through all triangles of the scene: the brute-force twin for tests. RT: set-up only.
  void use_all_triangles();

 private:
  SmoothMethod() = default;

  // A face met on a way.
  struct Hit {
    SetTriangle triangle;
    Vec3 X = Vec3::Zero();
    double measure = 0.0;  // the smaller, the better
    double side = 1.0;
    bool found = false;

    bool is_worse_than(double other_measure, const SetTriangle& other) const {
      return !found || other_measure < measure || (other_measure == measure && other.before(triangle));
    }
  };

  bool is_fresh() const { return set_.version == scene_->version(); }
  bool would_help(const Vec3& p, double radius) const;
  void select_at(const Vec3& p) noexcept;
  template <class Visit>
  void look_near(const Vec3& centre, double radius, Visit&& visit) noexcept;
  template <class Visit>
  void look_along(const Vec3& from, const Vec3& to, Visit&& visit) noexcept;

  Hit find_entry(const Vec3& from, const Vec3& to) noexcept;
  Hit seen_from(const Vec3& from, const Hit& grazed) noexcept;
  Hit find_block(const Vec3& from, const Vec3& to) noexcept;
  Hit find_on_line(const Vec3& P, const Vec3& outward, const Vec3& near, double reach) noexcept;
  Hit find_nearest_face(const Vec3& p, double reach) noexcept;
  bool is_behind_all(const Vec3& P) noexcept;
  Vec3 outward_at(const Vec3& p) noexcept;

  void enter(const Hit& hit) noexcept;
  bool track(const Vec3& P) noexcept;
  bool settle(const Vec3& P) noexcept;
  Hit find_obstacle(const SetTriangle& face, const Vec3& X) noexcept;
  bool descend(const Vec3& P) noexcept;
  Vec3 project_smoothly(const Vec3& P, double reach, Vec3& normal) noexcept;
  Vec3 held_near(const Vec3& p) const noexcept;
  MethodOutput step_at(const Vec3& P, double dt_s) noexcept;
  Vec3 outside_force(const Vec3& p) noexcept;
  MethodOutput feel_outside(const Vec3& P) noexcept;
  MethodOutput feel_inside(const Vec3& P) noexcept;

  std::unique_ptr<SmoothScene> scene_;
  std::uint32_t set_size_ = 64;
  double radius_ = 0.0;
  double layer_ = 0.0;  // metres
  bool all_triangles_ = false;
  std::vector<SetTriangle> all_;  // with all_triangles_
  bool has_slow_task_ = false;
  bool leaves_out_ = false;  // materials ask for friction or damping

  void ask_ahead() noexcept;

  Mailbox<LocalSetRequest> requests_;  // fast task to slow
  Mailbox<LocalSet> sets_;             // slow task to fast

  LocalSet set_;
  Vec3 P_ = Vec3::Zero();         // the last sample
  Vec3 velocity_ = Vec3::Zero();  // m/s
  bool started_ = false;
  bool inside_ = false;
  // While inside: the VCP, the face it lies on, and the side the probe came from (1: the side the normal points to).
  Vec3 V_ = Vec3::Zero();
  SetTriangle T_;
  double side_ = 1.0;

  SmoothCounters counters_;
};

}  // namespace hapton
