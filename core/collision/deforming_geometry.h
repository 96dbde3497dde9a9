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

// The box, grown for the rounding of what is computed inside it, by 2^-40 of its size and of its distance from the origin. RT: yes.
Box with_room_for_rounding(const Box& box);

// The box that holds a mesh at rest and in all its shapes, with room for rounding. RT: set-up only.
Box bounds_of_all_shapes(const TriangleMesh& mesh, const MeshDeformation& deformation);

// Checks that all triangles of one shape of a surface are walkable (SurfaceAdjacency). when: names the shape in the error. RT: set-up only.
Result<void> check_shape(const TriangleMesh& shape, const LocalFrame& frame, std::string_view when);

// Checks that all triangles of a deforming surface are walkable: at rest, and in at most about kMaxShapes shapes (fewer for large meshes),
// those of evenly chosen keys and half-way between them. RT: set-up only, builds a tree for each shape. Error: how many triangles are not
// walkable, and at which time: there the surface comes near itself, or is not locally manifold.
constexpr std::size_t kMaxShapes = 64;
Result<void> check_shapes(const TriangleMesh& mesh, const MeshDeformation& deformation);

// Gives the only object of a TouchGeometry the shape that it has at a given time.
//
// Only the vertices that the deformation moves are placed: linear in their number, some ns each. A step neither builds nor refits a tree:
// the time of the deformation is divided into up to kMaxTrees equal parts, each with its own tree, refitted beforehand, which has the same
// nodes and boxes that hold their triangles in all shapes of that part.
//
// Threads: one. RT: yes, shape() linear in the vertices that move; construction is set-up only.
class DeformingGeometry {
 public:
  // Enough that vertices move by less than half a mean edge per part on average, on a path of up to 32 edges; beyond, boxes are larger.
  static constexpr std::size_t kMaxTrees = 64;
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  // of all trees, if there are several

  // Pre: the geometry was made from this mesh with BuildPolicy::to_deform and the box bounds_of_all_shapes(), and outlives this object.
  // Begins with the shape at 0 s.
  DeformingGeometry(TouchGeometry& geometry, std::shared_ptr<const TriangleMesh> mesh, std::shared_ptr<const MeshDeformation> deformation);

  void shape(double time_s) noexcept;
  // These three are described at StreamedGeometry (shape_stage.h). No stages wait here, so the last two have nothing to do.
  double travel_to(double time_s) const noexcept { return deformation_->most_displacement(weights_, deformation_->weights_at(time_s)); }
  bool is_due(double /*time_s*/) const noexcept { return false; }
  void skip_to(double /*time_s*/) noexcept {}

  // The position of a vertex of the object at rest, and its displacement from one time to another; both local.
  Vec3 rest_of(std::uint32_t vertex) const noexcept;
  Vec3 displacement_between(std::uint32_t vertex, double from_s, double to_s) const noexcept;

  const MeshDeformation& deformation() const { return *deformation_; }
  std::size_t tree_count() const { return trees_.size(); }
  std::size_t bytes() const;

 private:
  void make_arrays();
  void make_trees();
  void move_vertices(const MeshDeformation::Weights& weights) noexcept;
  std::size_t part_at(double time_s) const noexcept;
  // The place of the vertex in moving_vertices_; none if the deformation does not move it.
  std::optional<std::size_t> find_moving(std::uint32_t vertex) const noexcept;
  std::size_t choose_count() const;

  TouchGeometry& geometry_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::shared_ptr<const MeshDeformation> deformation_;
  std::vector<std::uint32_t> moving_vertices_;  // numbers in the object of the vertices that move, ascending
  // Three coordinates for each vertex in moving_vertices_, local: its position at rest, and its displacement, for one target after the
  // other.
  std::vector<double> rest_coordinates_;
  std::vector<double> displacements_;
  std::vector<WideBvh> trees_;  // by part; the geometry has the tree of part_, and its own is stored in that place
  std::size_t part_ = 0;
  MeshDeformation::Weights weights_ = {};  // of the shape that the geometry has
};

}  // namespace hapton
