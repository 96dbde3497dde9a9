#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/worker_team.h"
#include "core/geometry/triangle_distance.h"
#include "core/tool/linearized_motion.h"
#include "core/tool/obb_tree.h"
#include "core/tool/separating_planes.h"

namespace hapton {

// Simultaneous traversal (a walk) of the trees of tool and scene over a motion of the tool: finds the pairs of triangles that may come
// within a distance of each other. Two boxes are separate if one of their six axes at the start of the motion separates their paths.
// So for a motion along a surface, boxes on opposite sides of the gap stay separate.
//
// The pairs of boxes at which a walk ended are kept, each with a lower bound of its distance (front tracking, Li & Chen 1998). The next
// walk begins at these pairs, and tests again only those that the tool's motion, since that bound was found and during this walk, could
// bring close enough. For a pair that a test found separate, a plane between its boxes is stored, which makes most later tests unnecessary.
//
// These pairs are distributed among the workers of a team. The workers' results are merged in the order of the pairs, so that the front,
// and whether a walk ends early, are the same with any number of workers.
// Work: at most kMaxTests pairs of boxes a worker in each walk. RT: for_each_near yes with one worker, construction set-up only. Pre: the
// trees and the team outlive this.
class ObbFront {
 public:
  static constexpr std::size_t kMaxTests = 1U << 20;

  // radius: the largest distance of a point of the tool from the grip point.
  ObbFront(const ObbTree& tool, const ObbTree& scene, double radius, WorkerTeam& team = calling_thread());

  // The worker that makes a visit, and the place of the visit: the index, among the pairs at which the walk begins, of the one that led to
  // it. Each worker visits in ascending order of places, and one worker makes all visits of a place.
  struct VisitId {
    int worker;
    std::uint32_t place;
  };
  // A visitor's result for a pair of triangles.
  struct Visited {
    double gap;    // lower bound of the distance at the start of the motion between the features that matter to the visitor
    double rest;   // the same for those of them that the visitor has not found before
    bool goes_on;  // false ends the walk
    // The pairs of features that `rest` leaves out: one bit each, in the visitor's numbering.
    std::uint16_t near = 0;
    // If a plane separates the pair over the motion: the plane's normal, from the scene to the tool, as SeparatingPlanes::normal_along
    // returns it, and the distance of the triangles along the normal at the start.
    bool has_plane = false;
    Vec3 normal = Vec3::Zero();
    double along_normal = 0.0;
  };
  static constexpr std::uint16_t kAllFeatures = 0xFFFF;

  // From now on all features count as not found before (Visited::rest).
  void forget() noexcept { ++epoch_; }
  // The next walk begins at the roots.
  void restart() noexcept { count_ = 0; }
  // Calls visit(turn, tool_triangle, scene_triangle, features) for all pairs that come within `distance` over the motion, and for some
  // whose bounds do not exclude it, except pairs whose new features (Visited::rest) stay farther away. Later walks visit a pair again if it
  // may have come within the distance. features: the visitor need test only these (Visited::near of an earlier visit); if none of them
  // comes within the distance, it tests all, for better bounds. False, and pairs are missing: a visitor ended the walk, it took more than
  // kMaxTests tests, or the front would exceed kMaxFrontPairs pairs. Threads: workers visit concurrently.
  template <class Visit>
  bool for_each_near(const LinearizedMotion& motion, double distance, Visit&& visit) noexcept;

  // Merges the results of the workers: calls use(item) for the items of all lists in the order of their places. list_of returns the list of
  // a worker, whose items are in ascending order of their member `place`.
  template <class Workers, class ListOf, class Use>
  static void for_each_by_place(const Workers& workers, ListOf&& list_of, Use&& use) noexcept;

 private:
  struct Pair {
    std::uint32_t tool;  // nodes
    std::uint32_t scene;
  };
  struct ToolBox {
    void place(const ObbTree::Node& tool, const LinearizedMotion& motion);

    std::uint64_t walk = 0;  // number of the walk for which the box was placed
    std::uint32_t node = 0;
    Vec3 centre;  // scene frame
    Vec3 half;
    Vec3 displacement;  // of the centre
    Mat3 axes;          // columns
    Lanes4 lanes[3];    // the rows of `axes`: one coordinate of all axes each
    Lanes4 half_lanes;
    Lanes4 displacement_lanes;  // along the axes
    double slack = 0.0;         // bound of how far the displacement of a point of the box differs from the centre's, plus rounding
    double still_slack = 0.0;   // the rounding alone
  };
  struct BoxGap {
    double distance = 0.0;              // lower bound at the start of the motion
    bool is_apart_over_motion = false;  // the boxes stay farther apart than the clearance over the motion
    Vec3 direction = Vec3::Zero();      // if requested: along the normal of a plane that stays between the boxes over the motion
  };
  struct alignas(32) Eight {
    std::array<float, SeparatingPlanes::kTogether> of;
  };
  // A pair where a walk has ended.
  struct End {
    Pair pair;
    float until;       // lower bound of its distance, plus travelled_ when that bound was found
    float rest_until;  // the same from Visited::rest
    std::uint32_t place;
    std::uint64_t visited_in;  // epoch of the last visit; 0: never visited
    std::uint16_t near = 0;    // see Visited
    bool has_plane = false;    // see Visited
    Vec3 normal = Vec3::Zero();
    double along_normal = 0.0;

    void set_plane(const Vec3& along, double gap) {
      has_plane = true;
      normal = along;
      along_normal = gap;
    }
  };
  // The data of one worker in a walk.
  struct Walker {
    std::vector<ToolBox> boxes;  // cache, by node number modulo kCachedBoxes
    std::vector<End> added;      // new pairs, in addition to those at which the walk began
    std::size_t tests = 0;
  };

  static BoxGap test(const ToolBox& tool, const ObbTree::Node& scene, double clearance, bool wants_direction = false) noexcept;
  const ToolBox& placed(Walker& walker, std::uint32_t node, const LinearizedMotion& motion) const noexcept;
  // Prepares a walk: finds the pairs at which it begins.
  void begin(const LinearizedMotion& motion, double distance) noexcept;
  void find_places(float max_travel, float clearance) noexcept;
  void begin_at_roots(const LinearizedMotion& motion, double distance) noexcept;
  // Appends the pairs that the walkers added to the front. False if there is no room, or there were too many tests.
  bool finish() noexcept;
  End end_of(Pair pair, double distance, double rest, std::uint32_t place, std::uint64_t visited_in) const noexcept;
  float& until(std::size_t i) noexcept { return until_[i / SeparatingPlanes::kTogether].of[i % SeparatingPlanes::kTogether]; }
  void put(std::size_t i, const End& end) noexcept;
  void put_again(std::size_t i, const End& end) noexcept;  // pre: `end` is of the pair that is stored at i
  void put_plane(std::size_t i, const End& end) noexcept;  // if `end` has a plane
  bool splits_tool(Pair pair) const noexcept;
  bool is_end(Pair pair) const noexcept;  // both nodes are leaves
  // Visits the pair at a place, which was visited before: a visit gives better bounds than a test of its boxes. False: the walk has to end.
  template <class Visit>
  bool visit_again(VisitId visit_id, const LinearizedMotion& motion, Visit&& visit) noexcept;
  // Walks down the trees from the pair at a place. False: the walk has to end.
  template <class Visit>
  bool descend(VisitId visit_id, const LinearizedMotion& motion, double distance, Visit&& visit) noexcept;

  static constexpr std::size_t kMaxFrontPairs = 1U << 17;  // pairs of the front
  static constexpr std::size_t kBlock = 64;                // pairs that share a bound (block_bounds_)
  static constexpr std::size_t kCachedBoxes = 512;         // boxes that a worker caches
  static constexpr std::size_t kMinFirstPairs = 256;       // a walk from the roots begins at that many pairs, to be shared out
  static constexpr double kFastTurn = 0x1p-7;              // rad in a walk: from this on, planes would soon be useless, and none is stored
  static constexpr std::size_t kTogether = 8;              // places that a worker takes at a time
  static constexpr std::size_t kMinPlacesForTeam = 32;  // with fewer places, one worker makes the walk: waking the others may take longer

  const ObbTree* tool_;
  const ObbTree* scene_;
  double radius_;
  WorkerTeam* team_;
  std::vector<Walker> walkers_;
  std::vector<Pair> front_pairs_;
  std::vector<Eight> until_;               // see End
  std::vector<float> block_bounds_;        // lower bound of until_ of each block
  std::vector<float> rest_until_;          // see End; used for visited pairs only
  std::vector<std::uint64_t> visited_in_;  // see End
  std::vector<std::uint16_t> near_;        // see End
  SeparatingPlanes planes_;
  std::uint64_t epoch_ = 1;            // number of calls of forget(), plus 1
  std::size_t count_ = 0;              // pairs of the front; 0: the next walk begins at the roots
  std::vector<std::uint32_t> places_;  // numbers of the pairs at which the walk begins
  std::size_t first_count_ = 0;        // count_ after the last walk from the roots
  Placement last_start_;               // of the tool, at the start of the last walk's motion
  double travelled_ = 0.0;             // bound of the path of a point of the tool since the walk from the roots
  float max_travel_ = 0.0F;            // no pair with a higher until_ comes within the distance in this walk
  std::uint64_t walk_ = 0;             // number of the walk
};

// ---------------------------------------------------------------------------------------------------------------------

template <class Visit>
bool ObbFront::for_each_near(const LinearizedMotion& motion, double distance, Visit&& visit) noexcept {
  if (tool_->nodes().empty() || scene_->nodes().empty()) return true;
  begin(motion, distance);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> goes_on = true;
  const auto walk = [&](int worker) noexcept {
    while (goes_on.load(std::memory_order_relaxed)) {
      const std::size_t first = next.fetch_add(kTogether, std::memory_order_relaxed);
      if (first >= places_.size()) return;
      const std::size_t last = std::min(first + kTogether, places_.size());
      for (std::size_t place = first; place < last; ++place) {
        const VisitId visit_id{worker, static_cast<std::uint32_t>(place)};
        const bool was_visited = visited_in_[places_[place]] != 0;
        if (was_visited ? visit_again(visit_id, motion, visit) : descend(visit_id, motion, distance, visit)) continue;
        goes_on.store(false, std::memory_order_relaxed);
        return;
      }
    }
  };
  if (places_.size() < kMinPlacesForTeam) {
    walk(0);
  } else {
    team_->run(walk);
  }
  const bool is_whole = goes_on && finish();
  if (!is_whole) count_ = 0;
  if (first_count_ == 0) first_count_ = count_;
  return is_whole;
}

template <class Visit>
bool ObbFront::visit_again(VisitId visit_id, const LinearizedMotion& motion, Visit&& visit) noexcept {
  if (++walkers_[static_cast<std::size_t>(visit_id.worker)].tests > kMaxTests) return false;
  const std::uint32_t at = places_[visit_id.place];
  const Pair pair = front_pairs_[at];
  const ObbTree::Node& tool = tool_->nodes()[pair.tool];
  const float rest = rest_until_[at];
  const bool is_partial = visited_in_[at] != epoch_ && rest > max_travel_;
  const Visited found =
      visit(visit_id, tool_->triangle(tool), scene_->triangle(scene_->nodes()[pair.scene]), is_partial ? near_[at] : kAllFeatures);
  if (!found.goes_on) return false;
  End end = end_of(pair, found.gap, found.rest, visit_id.place, epoch_);
  end.near = found.near;
  if (is_partial && found.near != 0) {
    end.until = std::min(end.until, rest);
    end.rest_until = std::min(end.rest_until, rest);
  }
  if (found.has_plane && motion.angle < kFastTurn) end.set_plane(found.normal, found.along_normal);
  put_again(at, end);
  return true;
}

template <class Visit>
bool ObbFront::descend(VisitId visit_id, const LinearizedMotion& motion, double distance, Visit&& visit) noexcept {
  Walker& walker = walkers_[static_cast<std::size_t>(visit_id.worker)];
  const std::uint32_t from = places_[visit_id.place];
  const bool wants_plane = motion.angle < kFastTurn;
  bool is_first = true;
  bool has_replaced = false;
  std::array<Pair, 2 * ObbTree::kMaxDepth + 2> stack;
  int top = 0;
  stack[top++] = front_pairs_[from];
  while (top > 0) {
    const Pair pair = stack[--top];
    if (++walker.tests > kMaxTests) return false;
    const ObbTree::Node& tool = tool_->nodes()[pair.tool];
    const ObbTree::Node& scene = scene_->nodes()[pair.scene];
    const BoxGap box_gap = test(placed(walker, pair.tool, motion), scene, distance, wants_plane);
    if (box_gap.is_apart_over_motion || is_end(pair)) {
      const Visited found = box_gap.is_apart_over_motion ? Visited{0.0, 0.0, true}
                                                         : visit(visit_id, tool_->triangle(tool), scene_->triangle(scene), kAllFeatures);
      if (!found.goes_on) return false;
      End end = end_of(pair, std::max(box_gap.distance, found.gap), std::max(box_gap.distance, found.rest), visit_id.place,
                       box_gap.is_apart_over_motion ? 0 : epoch_);
      end.near = found.near;
      if (wants_plane && box_gap.is_apart_over_motion) {
        const Vec3 normal = SeparatingPlanes::normal_along(box_gap.direction);
        end.set_plane(normal, planes_.gap_along(normal, tool, scene));
      } else if (wants_plane && found.has_plane) {
        end.set_plane(found.normal, found.along_normal);
      }
      if (has_replaced) {
        if (walker.added.size() == kMaxFrontPairs) return false;
        walker.added.push_back(end);
      } else if (!is_first) {
        put(from, end);
      } else {
        put_again(from, end);
      }
      has_replaced = true;
    } else if (splits_tool(pair)) {
      stack[top++] = {tool.link + 1, pair.scene};
      stack[top++] = {tool.link, pair.scene};
    } else {
      stack[top++] = {pair.tool, scene.link + 1};
      stack[top++] = {pair.tool, scene.link};
    }
    is_first = false;
  }
  return true;
}

template <class Workers, class ListOf, class Use>
void ObbFront::for_each_by_place(const Workers& workers, ListOf&& list_of, Use&& use) noexcept {
  std::array<std::size_t, WorkerTeam::kMaxWorkers> at = {};
  for (;;) {
    // The worker whose next item has the lowest place has all items of that place.
    std::size_t first = workers.size();
    std::uint32_t place = std::numeric_limits<std::uint32_t>::max();
    for (std::size_t w = 0; w < workers.size(); ++w) {
      const auto& list = list_of(workers[w]);
      if (at[w] == list.size() || list[at[w]].place >= place) continue;
      first = w;
      place = list[at[w]].place;
    }
    if (first == workers.size()) return;
    const auto& list = list_of(workers[first]);
    for (; at[first] < list.size() && list[at[first]].place == place; ++at[first]) use(list[at[first]]);
  }
}

}  // namespace hapton
