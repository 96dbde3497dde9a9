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

// Counters since construction.
struct SmoothCounters {
  std::uint64_t steps = 0;
  std::uint64_t skipped = 0;        // steps in which the set showed that no triangle is near
  std::uint64_t selections = 0;     // sets that the fast task had to select itself
  std::uint64_t offered = 0;        // sets received from the slow task
  std::uint64_t late = 0;           // selections while a slow task runs: its set was not enough
  std::uint64_t overflows = 0;      // queries that even a fresh set could not cover; left to the tree
  std::uint64_t entries = 0;        // the probe passed through the surface
  std::uint64_t releases = 0;       // the probe came out again
  std::uint64_t missed_lines = 0;   // the outward line met no face: the VCP moved over the surface from where it was
  std::uint64_t hidden = 0;         // VCPs removed as hidden, fig. 3 of the paper
  std::uint64_t over_capacity = 0;  // VCPs beyond the capacity of one step
};

// The method of the FDH paper, complete: the fast task computes the force from a small set of triangles near the probe (Algorithm 1: smooth
// normals, hidden VCPs removed). A probe that has passed through the surface is tracked by its VCP (fig. 4), so the force still comes from
// the outside. The force depends only on the last positions of probe and VCP and the triangles within RADIUS of them or near their motion.
// Two sets that are complete there give the same force to the last bit, so an exchange of sets cannot be felt. A step never uses a set
// beyond the set's radius: it then selects a set itself, and if none is large enough it queries the tree; both are counted. f: outside the
// surface a spring over `layer` (0: contact begins at the surface, as in all other methods); inside, that spring's full force plus the
// spring from VCP to probe. Material: stiffness and two_sided; TouchStep adds friction and damping. Where the paper leaves a choice:
// docs/decisions/0003-fdh-smooth.md. Frame S. Threads: one; prepare in a second one, except while vertices move. scene() may be read from
// any thread while no vertices move. RT: step, reset, request, offer yes; bounded time while counters().overflows does not change.
class SmoothMethod final : public ForceMethod {
 public:
  // RT: set-up only. Error: a setting that is out of range; see SmoothScene::build.
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::span<const Material> unrendered_drag() const noexcept override { return materials_; }
  std::string describe() const override;

  // The slow task: selects the set that the fast task requested last, and hands it over. False: there was no new request.
  bool prepare() override;

  // For a caller's own slow task in place of prepare(): it selects with scene().select(request, set_size(), set) whenever it likes; request
  // and offer belong to the thread of step. offer takes over `set` unless the current one is better; later selections count as late.
  LocalSetRequest request() const noexcept;
  void offer(const LocalSet& set) noexcept;
  const SmoothScene& scene() const { return *scene_; }
  std::uint32_t set_size() const { return set_size_; }

  // Call when an object's vertices have moved since the last step; `vertices`: in the order of its mesh. The VCP moves with its triangle; a
  // probe that the surface has passed over is then inside. RT: no (linear in the object). Error: see SmoothScene::move_vertices.
  Result<void> move_vertices(std::uint32_t object, std::span<const Vec3> vertices);

  const SmoothCounters& counters() const { return counters_; }
  double radius_m() const { return radius_; }
  double layer_m() const { return layer_; }  // distance from the surface at which f begins
  bool is_inside() const { return is_inside_; }
  const LocalSet& local_set() const { return set_; }

  // Every query uses all triangles of the scene: the brute-force twin for tests. RT: set-up only.
  void use_all_triangles();

 private:
  SmoothMethod() = default;

  // A face that a path meets.
  struct Hit {
    SetTriangle triangle;
    Vec3 X = Vec3::Zero();
    double measure = 0.0;  // distance or position on the path: the smallest one wins
    double side = 1.0;
    bool found = false;

    bool is_worse_than(double other_measure, const SetTriangle& other) const {
      return !found || other_measure < measure || (other_measure == measure && other.before(triangle));
    }
  };

  // The triangles that a query visits: those of the set, or all.
  std::span<const SetTriangle> query_triangles() const {
    return all_triangles_ ? std::span<const SetTriangle>(all_) : std::span(set_.triangles).first(set_.count);
  }
  bool is_fresh() const { return set_.version == scene_->version(); }
  bool new_set_could_cover(const Vec3& p, double radius) const;
  void select_at(const Vec3& p) noexcept;
  template <class Visit>
  void visit_near(const Vec3& centre, double radius, Visit&& visit) noexcept;
  template <class Visit>
  void visit_along(const Vec3& from, const Vec3& to, Visit&& visit) noexcept;

  Hit find_entry(const Vec3& from, const Vec3& to) noexcept;
  Hit resolve_side(const Vec3& from, const Hit& grazed) noexcept;
  Hit find_block(const Vec3& from, const Vec3& to) noexcept;
  Hit find_on_line(const Vec3& P, const Vec3& outward, const Vec3& near, double radius) noexcept;
  Hit find_nearest_face(const Vec3& p, double radius) noexcept;
  bool is_behind_all(const Vec3& P) noexcept;
  Vec3 outward_at(const Vec3& p) noexcept;

  void enter(const Hit& hit) noexcept;
  void stay_at(const Hit& hit) noexcept;
  bool track(const Vec3& P) noexcept;
  bool settle(const Vec3& P) noexcept;
  Hit find_obstacle(const SetTriangle& face, const Vec3& X) noexcept;
  bool descend(const Vec3& P) noexcept;
  Vec3 project_smoothly(const Vec3& P, double radius, Vec3& normal) noexcept;
  Vec3 within_limits(const Vec3& p) const noexcept;
  MethodOutput step_at(const Vec3& P, double dt_s) noexcept;
  Vec3 outside_force(const Vec3& p) noexcept;
  MethodOutput compute_outside(const Vec3& P) noexcept;
  MethodOutput compute_inside(const Vec3& P) noexcept;

  std::unique_ptr<SmoothScene> scene_;
  std::vector<Material> materials_;  // by object
  std::uint32_t set_size_ = 64;
  double radius_ = 0.0;
  double layer_ = 0.0;  // metres
  bool all_triangles_ = false;
  std::vector<SetTriangle> all_;  // filled only if all_triangles_
  bool has_slow_task_ = false;
  std::string unrendered_notes_;  // what of the scene is not rendered: lines for describe()

  void request_ahead() noexcept;

  Mailbox<LocalSetRequest> requests_;  // fast task to slow
  Mailbox<LocalSet> sets_;             // slow task to fast

  LocalSet set_;
  Vec3 P_ = Vec3::Zero();         // the last sample
  Vec3 velocity_ = Vec3::Zero();  // m/s
  bool has_started_ = false;
  bool is_inside_ = false;
  // While inside: the VCP, the face it lies on, and the side the probe came from (1: the side the normal points to).
  Vec3 V_ = Vec3::Zero();
  SetTriangle T_;
  double side_ = 1.0;

  SmoothCounters counters_;
};

}  // namespace hapton
