#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/base/large_vector.h"
#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/carve.h"
#include "core/sculpt/field_grid.h"

namespace hapton {

// A box of nodes of a field, half-open: low <= node < high along x, y and z.
struct CarvedFieldBox {
  std::array<int, 3> low = {0, 0, 0};
  std::array<int, 3> high = {0, 0, 0};

  bool is_empty() const { return low[0] >= high[0] || low[1] >= high[1] || low[2] >= high[2]; }
};

// A body of material as a signed distance field: a dense grid of floats, metres, positive outside, linear along each axis between the
// nodes. Distances are limited to a band of kBandVoxels spacings on both sides of the surface. A carve removes a capsule from the body:
// field = max(field, -distance to the capsule). The order of carves does not matter, and a repeated carve changes nothing, to the last bit.
// Outside the body, the value at a node is at most the distance to the body, up to rounding, also after carving: it bounds a safe step.
// Frame: that of the mesh (the static scene S). Threads: one at a time. Source: decision 160.
class CarvedField {
 public:
  static constexpr int kBandVoxels = 3;                           // gradients and steps along the surface need two
  static constexpr std::size_t kMaxNodes = std::size_t{1} << 24;  // 64 MiB

  // The grid that make() would use. Error, in one line: the mesh is not closed, or the voxel is not positive or too small for kMaxNodes.
  // RT: set-up only.
  static Result<FieldGrid> plan(const TriangleMesh& mesh, double voxel_m);
  // Makes the field of a mesh. Error: as plan(). RT: set-up only.
  static Result<CarvedField> make(const TriangleMesh& mesh, double voxel_m);

  // Removes a capsule. Returns a box around the changed nodes whose old value was below two spacings, since only these can move the surface
  // or its normals; empty if there is none. A carve that is not finite, or has no positive radius, changes nothing. Time: proportional to
  // the nodes within the capsule's box and the band. RT: yes.
  CarvedFieldBox carve(const Carve& carve) noexcept;

  // Whether carve() would return a box that is not empty. Time: as carve, usually much less. RT: yes.
  bool would_change(const Carve& carve) const noexcept;

  // The nodes whose values the carve can change, along x widened to whole blocks of eight nodes; empty: there are none. RT: yes.
  CarvedFieldBox reach(const Carve& carve) const noexcept;
  // Like carve(), but only at the nodes in the box. Pre: along x the box begins and ends at multiples of eight, as from reach(). RT: yes.
  void carve_within(const Carve& carve, const CarvedFieldBox& box) noexcept;
  // Takes the values of the nodes in the box from a field of the same grid. RT: yes.
  void copy(const CarvedField& other, const CarvedFieldBox& box) noexcept;

  // The field at p, within [-band_m(), band_m()]; outside the grid band_m() plus the distance to the grid. Continuous. RT: yes.
  double value(const Vec3& p) const noexcept;

  // The gradient by central differences over two spacings, continuous; about unit length near the surface, zero far inside. It points out
  // of the body. RT: yes.
  Vec3 gradient(const Vec3& p) const noexcept;

  const FieldGrid& grid() const noexcept { return grid_; }
  const Vec3& origin_m() const noexcept { return grid_.origin_m; }
  double spacing_m() const noexcept { return grid_.spacing_m; }
  const std::array<int, 3>& nodes() const noexcept { return grid_.nodes; }  // nodes()[0] is a multiple of 8
  double band_m() const noexcept { return band_m_; }

  // The values of all nodes, x fastest (FieldGrid::index).
  std::span<const float> values() const noexcept { return {blocks_.front().lanes.data(), grid_.size()}; }

 private:
  struct alignas(32) Block {
    std::array<float, 8> lanes;
  };

  explicit CarvedField(const FieldGrid& grid);
  // Calls visit(block, y and z of the row, x of the block's first node, values that the carve alone would give) for each block of eight
  // nodes within reach of the capsule and its band, until visit returns false. Blocks and rows outside the box are left out.
  template <class Visit>
  void visit_reach(const Carve& carve, const CarvedFieldBox& within, Visit&& visit) const noexcept;
  CarvedFieldBox all_nodes() const noexcept { return {{0, 0, 0}, grid_.nodes}; }
  std::span<float> mutable_values() noexcept { return {blocks_.front().lanes.data(), grid_.size()}; }

  FieldGrid grid_;
  double per_spacing_ = 0.0;
  Vec3 last_node_ = Vec3::Zero();  // number of the last node along x, y, z
  double band_m_ = 0.0;
  LargeVector<Block> blocks_;
};

}  // namespace hapton
