#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/collision/touch_geometry.h"

namespace hapton {

// A straight motion of all vertices of a surface from one shape to the next, made ready for StreamedGeometry.
struct ShapeStage {
  std::vector<Vec3> begin;           // where the vertices of the mesh are at the beginning, frame S, in m
  std::vector<Vec3> to;              // where they are at the end, likewise
  std::vector<double> begin_local;   // the beginning, local: three coordinates for each vertex of the object, on its grid
  std::vector<double> motion_local;  // what to add to `begin_local` to get to the end; exact
  std::vector<WideBvh> trees;        // one for each of equal parts of the motion; its boxes hold their triangles in all shapes of that part
  double most_m = 0.0;               // no vertex moves farther
};

// Makes stages of a surface whose shapes are not known beforehand. RT: no. Threads: const calls from any number, also while the geometry
// is in use.
class ShapeStager {
 public:
  static constexpr std::size_t kMaxTrees = 8;

  // Pre: the geometry was made from this mesh with BuildPolicy::to_deform and the box bounds_with_reach(); no vertex has been moved yet.
  ShapeStager(const TouchGeometry& geometry, std::shared_ptr<const TriangleMesh> mesh, double reach_m);

  // The surface at rest: a stage on which nothing moves.
  std::unique_ptr<ShapeStage> make_rest() const;
  // A stage between two shapes, in frame S. Work: builds two trees over the mesh, refits up to kMaxTrees. Pre: `from` is `to` of an earlier
  // stage. Error: `to` has another number of vertices than the mesh, or one that is not finite or farther than reach_m from its place at
  // rest; triangles are not walkable (SurfaceAdjacency) in the shape at the end or half-way.
  Result<std::unique_ptr<ShapeStage>> make(std::span<const Vec3> from, std::span<const Vec3> to) const;

  std::span<const Vec3> rest() const { return mesh_->vertices; }

 private:
  Result<void> check(std::span<const Vec3> from, std::span<const Vec3> to) const;
  std::vector<double> to_local(std::span<const Vec3> shape) const;
  std::size_t choose_count(double most_m) const;

  std::shared_ptr<const TriangleMesh> mesh_;
  double reach_m_;
  LocalFrame frame_;
  std::vector<std::uint32_t> new_vertex_;  // for each vertex of the mesh, its number in the object
  std::size_t vertex_count_;               // of the object
  std::vector<Triangle> triangles_;        // of the object
  WideBvh tree_;
  double mean_edge_m_;
};

// The box of a mesh, in frame S, whose vertices move by at most reach_m from rest, with room for rounding. RT: set-up only.
Box bounds_with_reach(const TriangleMesh& mesh, double reach_m);

// Gives the only object of a TouchGeometry the shape that it has at a given time, in stages that arrive one by one: a stage begins when the
// one before it has ended, in exactly the shape in which that ended. A few stages can wait, each for its start.
//
// Threads: one. RT: yes, shape() linear in the vertices, some ns each; construction, vertices_at() set-up only. Stages that are no longer
// used are returned to the caller, to be destroyed outside of the step; their contents are not specified.
class StreamedGeometry {
 public:
  // `rest`: from ShapeStager::make_rest(). Pre: the geometry is the one that the stager was made for, and outlives this object.
  StreamedGeometry(TouchGeometry& geometry, std::unique_ptr<ShapeStage> rest);

  static constexpr std::size_t kMaxWaiting = 8;  // a quarter of a second of 30 shapes a second

  struct Released {
    std::unique_ptr<ShapeStage> ended;
    std::unique_ptr<ShapeStage> replaced;
  };
  // Puts a stage of over_s seconds in place of the stage that waits: it begins at now_s, or when the present stage has ended, if that is
  // later. Returns the stage that it replaces, and one that is no longer used; null: none. Pre: it was made from `to` of the present stage;
  // over_s is 0 or more; now_s is not before the last shape() or skip_to(); at most one stage waits.
  Released offer(std::unique_ptr<ShapeStage> stage, double over_s, double now_s) noexcept;
  // Puts a stage behind all others: it begins at start_s, or when the one before it has ended, if that is later. Returns a stage that is no
  // longer used; null: none. Pre: fewer than kMaxWaiting stages wait; it was made from `to` of newest(); over_s and start_s as in offer().
  std::unique_ptr<ShapeStage> append(std::unique_ptr<ShapeStage> stage, double over_s, double start_s) noexcept;

  // The position of a vertex of the object at rest, and its displacement from one time to another; both local. The displacement is that of
  // the present stage and of the one before it; motion in other stages is left out.
  Vec3 rest_of(std::uint32_t vertex) const noexcept { return at(rest_, vertex); }
  Vec3 displacement_between(std::uint32_t vertex, double from_s, double to_s) const noexcept {
    Vec3 moved = (present_.share_at(to_s) - present_.share_at(from_s)) * at(present_.stage->motion_local, vertex);
    const std::vector<double>& ended = ended_.stage != nullptr ? ended_.stage->motion_local : ended_motion_;
    if (!ended.empty() && from_s < present_.start_s) moved += (1.0 - ended_.share_at(from_s)) * at(ended, vertex);
    return moved;
  }

  // The stage that moves now, or the last one that ended; the next one must begin where it ends. serial(): how many stages have begun.
  const ShapeStage& present() const noexcept { return *present_.stage; }
  std::uint64_t serial() const noexcept { return serial_; }
  std::size_t waiting() const noexcept { return waiting_count_; }
  // The last of the stages that wait, or the present one if none waits; end_s(): when that stage ends.
  const ShapeStage& newest() const noexcept { return *last().stage; }
  double end_s() const noexcept { return last().end_s(); }

  // An upper bound, in m, of the distance of any vertex at that time from where it is in the geometry.
  double travel_to(double time_s) const noexcept;
  // Whether the next stage begins by that time: then shape() must be called even if nothing moves.
  bool is_due(double time_s) const noexcept { return waiting_count_ > 0 && time_s >= waiting_[0].start_s; }
  void shape(double time_s) noexcept;
  // Begins the stages that are due, but does not move the vertices: the geometry must not be queried before the next shape().
  void skip_to(double time_s) noexcept;

  // The vertices of the mesh at a time not before the last shape() or skip_to(), frame S. RT: no.
  std::vector<Vec3> vertices_at(double time_s) const;
  std::size_t bytes() const noexcept;

 private:
  // A stage, and when it moves: for over_s seconds from start_s on.
  struct TimedStage {
    std::unique_ptr<ShapeStage> stage = nullptr;
    double start_s = 0.0;
    double over_s = 0.0;
    double end_s() const noexcept { return start_s + over_s; }
    double share_at(double time_s) const noexcept {
      return time_s >= end_s() ? 1.0 : time_s <= start_s ? 0.0 : (time_s - start_s) / over_s;
    }
  };
  // The stage at a given time, and the sum of most_m of all stages before it.
  struct StageAt {
    const TimedStage& timed;
    double travelled_m = 0.0;
  };
  static Vec3 at(const std::vector<double>& numbers, std::uint32_t vertex) noexcept { return Vec3::Map(&numbers[3 * std::size_t{vertex}]); }
  const TimedStage& last() const noexcept { return waiting_count_ > 0 ? waiting_[waiting_count_ - 1] : present_; }
  StageAt find(double time_s) const noexcept;
  std::unique_ptr<ShapeStage> take_retired() noexcept;
  void advance() noexcept;

  TouchGeometry& geometry_;
  std::vector<double> rest_;  // laid out as ShapeStage::begin_local
  TimedStage present_;
  TimedStage ended_;                             // the stage before present_; it is null after it has been returned
  std::vector<double> ended_motion_;             // then its motion
  std::array<TimedStage, kMaxWaiting> waiting_;  // the next one first
  std::size_t waiting_count_ = 0;
  // Stages that ended before ended_ and have not been returned yet, the oldest first. Each stage that arrives makes one of these or ended_
  // return, so these, ended_ and the waiting stages are at most kMaxWaiting.
  std::array<std::unique_ptr<ShapeStage>, kMaxWaiting> retired_;
  std::size_t retired_count_ = 0;
  std::uint64_t serial_ = 0;
  std::size_t part_ = 0;               // of the present stage: the geometry has its tree, and its own is stored in that place
  double travelled_m_ = 0.0;           // sum of most_m of all stages before the present one
  double travelled_at_shape_m_ = 0.0;  // travelled up to the shape that the geometry has
};

}  // namespace hapton
