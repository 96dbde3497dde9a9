#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/collision/touch_geometry.h"
#include "core/geometry/mesh_deformation.h"

namespace hapton {

// The mean length of the triangles' edges, in m; 0 without triangles. RT: set-up only.
double compute_mean_edge(const TriangleMesh& mesh);

// A box with room for the rounding of what is computed of its content, a 2^-40th of its size and of its distance from the origin. RT: yes.
Box with_room_for_rounding(const Box& box);

// The box that holds a mesh at rest and in all its shapes, with room for rounding. RT: set-up only.
Box bounds_of_all_shapes(const TriangleMesh& mesh, const MeshDeformation& deformation);

// Checks that all triangles of a surface in one shape are walkable (SurfaceAdjacency). when: for the message. RT: set-up only, a tree.
Result<void> check_shape(const TriangleMesh& shape, const LocalFrame& frame, std::string_view when);

// Checks that all triangles of a deforming surface are walkable: at rest, and in about kMaxShapes evenly chosen shapes
// at the keys and half-way between them (in fewer for large meshes). RT: set-up only, a tree for each shape. Error: how many triangles are
// not walkable at which time, because the surface comes near itself or more than two triangles meet.
constexpr std::size_t kMaxShapes = 64;
Result<void> check_shapes(const TriangleMesh& mesh, const MeshDeformation& deformation);

// Gives the one object of a TouchGeometry the shape of a time.
//
// The vertices that the deformation moves are put where they are then: linear in their number, some ns each. The tree is not built again,
// nor refitted by a step: there is one for each of up to kMaxTrees equal parts of the deformation, the same nodes with boxes that hold
// their triangles in all shapes of that part, refitted beforehand.
//
// Threads: one. RT: yes, shape() linear in the vertices that move; construction is set-up only.
class DeformingGeometry {
 public:
  // With choose_count() vertices move by less than half an edge in each part, up to a path of 32 edges; then boxes are larger.
  static constexpr std::size_t kMaxTrees = 64;
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  // of all trees

  // Pre: the geometry was made with BuildPolicy::to_deform of this mesh, in bounds_of_all_shapes(). It outlives this. Begins with the shape
  // at 0 s.
  DeformingGeometry(TouchGeometry& geometry, std::shared_ptr<const TriangleMesh> mesh, std::shared_ptr<const MeshDeformation> deformation);

  void shape(double time_s) noexcept;
  // As those of StreamedGeometry (shape_stage.h).
  double travel_to(double time_s) const noexcept { return deformation_->most_displacement(weights_, deformation_->weights_at(time_s)); }
  bool is_due(double /*time_s*/) const noexcept { return false; }
  void skip_to(double /*time_s*/) noexcept {}

  // Of a vertex of the object, local: where it is at rest, and how far it moves from one time to another.
  Vec3 rest_of(std::uint32_t vertex) const noexcept;
  Vec3 moved_between(std::uint32_t vertex, double from_s, double to_s) const noexcept;

  const MeshDeformation& deformation() const { return *deformation_; }
  std::size_t tree_count() const { return trees_.size(); }
  std::size_t bytes() const;

 private:
  void make_arrays();
  void make_trees();
  void move_vertices(const MeshDeformation::Weights& weights) noexcept;
  std::size_t part_at(double time_s) const noexcept;
  // Of those that move; none: it stays.
  std::optional<std::size_t> find_moving(std::uint32_t vertex) const noexcept;
  std::size_t choose_count() const;

  TouchGeometry& geometry_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::shared_ptr<const MeshDeformation> deformation_;
  std::vector<std::uint32_t> vertex_;  // of the object, those that move, ascending
  // In their order, three numbers each, local: at rest, and the displacements target by target.
  std::vector<double> rest_;
  std::vector<double> displacements_;
  std::vector<WideBvh> trees_;  // by part; that of part_ is in the geometry, whose first one is here
  std::size_t part_ = 0;
  MeshDeformation::Weights weights_ = {};  // of the present shape
};

}  // namespace hapton
