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
  std::vector<Vec3> begin;     // where the vertices of the mesh begin, frame S
  std::vector<Vec3> to;        // and where they end
  std::vector<double> from;    // three numbers for each vertex of the object, local, on its grid
  std::vector<double> motion;  // from there to the end; exact
  std::vector<WideBvh> trees;  // by equal parts of the motion: boxes that hold their triangles in all shapes of that part
  double most_m = 0.0;         // no vertex moves farther
};

// Makes stages of a surface whose shapes are not known beforehand. RT: no. Threads: const calls from any number, while the geometry is
// used.
class ShapeStager {
 public:
  static constexpr std::size_t kMaxTrees = 8;

  // Pre: the geometry was made with BuildPolicy::to_deform of this mesh, in bounds_with_reach(), and no vertex has been moved yet.
  ShapeStager(const TouchGeometry& geometry, std::shared_ptr<const TriangleMesh> mesh, double reach_m);

  // The surface at rest: a stage on which nothing moves.
  std::unique_ptr<ShapeStage> make_rest() const;
  // From a shape that an earlier stage led to. Work: that of two trees over the mesh. Error: the number of vertices is not the mesh's; one
  // is not finite, or farther than reach_m from where it is at rest; a shape in which triangles are not walkable (SurfaceAdjacency), at its
  // end or half-way.
  Result<std::unique_ptr<ShapeStage>> make(std::span<const Vec3> from, std::span<const Vec3> to) const;

  std::span<const Vec3> rest() const { return mesh_->vertices; }

 private:
  Result<void> check(std::span<const Vec3> from, std::span<const Vec3> to) const;
  std::vector<double> to_local(std::span<const Vec3> shape) const;
  std::size_t choose_count(double most_m) const;

  std::shared_ptr<const TriangleMesh> mesh_;
  double reach_m_;
  LocalFrame frame_;
  std::vector<std::uint32_t> new_vertex_;  // number in the object of each of the mesh's vertices
  std::size_t vertex_count_;               // of the object
  std::vector<Triangle> triangles_;        // of the object
  WideBvh tree_;
  double mean_edge_m_;
};

// The box of a mesh whose vertices move no farther than that, with room for rounding. RT: set-up only.
Box bounds_with_reach(const TriangleMesh& mesh, double reach_m);

// Gives the one object of a TouchGeometry the shape of a time, of shapes that come one by one: a stage begins when the one before has
// ended, exactly where that ends. A few can wait, each for its start.
//
// Threads: one. RT: yes, shape() linear in the vertices, some ns each; construction is set-up only. The stages that are given back may be
// destroyed elsewhere.
class StreamedGeometry {
 public:
  // Pre: the geometry is that of the stager, and outlives this.
  StreamedGeometry(TouchGeometry& geometry, std::unique_ptr<ShapeStage> rest);

  static constexpr std::size_t kMaxWaiting = 8;  // a quarter of a second of 30 shapes a second

  struct Released {
    std::unique_ptr<ShapeStage> ended;
    std::unique_ptr<ShapeStage> replaced;
  };
  // The stage that comes next, for so many seconds: it begins at now_s, or when the present one has ended, in place of those that wait.
  // Pre: it was made from `to` of the present stage; over_s 0 or more; now_s is not before the last shape() or skip_to(); one waits at
  // most.
  Released offer(std::unique_ptr<ShapeStage> stage, double over_s, double now_s) noexcept;
  // The stage that comes after all others: it begins at start_s, or when the one before has ended. Returned: one that is used no more;
  // null: none. Pre: fewer than kMaxWaiting wait; it was made from `to` of newest(); as offer().
  std::unique_ptr<ShapeStage> append(std::unique_ptr<ShapeStage> stage, double over_s, double start_s) noexcept;

  // Of a vertex of the object, local: where it is at rest, and how far it moves from one time to another.
  // Pre: no stage but the present one and the one before it in between; of others the motion is left out.
  Vec3 rest_of(std::uint32_t vertex) const noexcept { return at(rest_, vertex); }
  Vec3 moved_between(std::uint32_t vertex, double from_s, double to_s) const noexcept {
    Vec3 moved = (present_.share_at(to_s) - present_.share_at(from_s)) * at(present_.stage->motion, vertex);
    if (ended_.stage != nullptr && from_s < present_.start_s) moved += (1.0 - ended_.share_at(from_s)) * at(ended_.stage->motion, vertex);
    return moved;
  }

  // The stage that moves now, or has ended; the next one has to begin where it ends. Its number counts the stages that have begun.
  const ShapeStage& present() const noexcept { return *present_.stage; }
  std::uint64_t serial() const noexcept { return serial_; }
  std::size_t waiting() const noexcept { return waiting_count_; }
  // The last one that waits; else the present one. And when it will have ended.
  const ShapeStage& newest() const noexcept { return *last().stage; }
  double end_s() const noexcept { return last().end_s(); }

  // No vertex is farther at that time than this from where it is in the geometry.
  double travel_to(double time_s) const noexcept;
  // A new stage has begun by then: shape() has to be called also if nothing moves.
  bool is_due(double time_s) const noexcept { return waiting_count_ > 0 && time_s >= waiting_[0].start_s; }
  void shape(double time_s) noexcept;
  // The time has come, but the geometry keeps its shape. Until shape() nothing may be asked of it.
  void skip_to(double time_s) noexcept;

  // The vertices of the mesh at a time not before the last shape() or skip_to(), frame S. RT: no.
  std::vector<Vec3> vertices_at(double time_s) const;
  std::size_t bytes() const noexcept;

 private:
  // A stage, and when it moves.
  struct Timed {
    std::unique_ptr<ShapeStage> stage = nullptr;
    double start_s = 0.0;
    double over_s = 0.0;
    double end_s() const noexcept { return start_s + over_s; }
    double share_at(double time_s) const noexcept {
      return time_s >= end_s() ? 1.0 : time_s <= start_s ? 0.0 : (time_s - start_s) / over_s;
    }
  };
  // The stage of a time, and what all before it travelled.
  struct Found {
    const Timed& timed;
    double travelled_m = 0.0;
  };
  static Vec3 at(const std::vector<double>& numbers, std::uint32_t vertex) noexcept { return Vec3::Map(&numbers[3 * std::size_t{vertex}]); }
  const Timed& last() const noexcept { return waiting_count_ > 0 ? waiting_[waiting_count_ - 1] : present_; }
  Found find(double time_s) const noexcept;
  std::unique_ptr<ShapeStage> take_used() noexcept;
  void advance() noexcept;

  TouchGeometry& geometry_;
  std::vector<double> rest_;  // as ShapeStage::from
  Timed present_;
  Timed ended_;                             // before it
  std::array<Timed, kMaxWaiting> waiting_;  // the next one first
  std::size_t waiting_count_ = 0;
  // Ended before ended_, and not given back yet, the oldest first. Each stage that comes takes one away, so with those that wait there are
  // kMaxWaiting at most.
  std::array<std::unique_ptr<ShapeStage>, kMaxWaiting> used_;
  std::size_t used_count_ = 0;
  std::uint64_t serial_ = 0;
  std::size_t part_ = 0;      // whose tree is in the geometry, whose own first one is there
  double travelled_m_ = 0.0;  // of all stages before the present one, each its most_m
  double shaped_at_m_ = 0.0;  // travelled by the shape in the geometry
};

}  // namespace hapton
