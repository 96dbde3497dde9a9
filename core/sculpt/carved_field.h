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

// Nodes of a field, half-open: low <= node < high along x, y and z.
struct CarvedFieldBox {
  std::array<int, 3> low = {0, 0, 0};
  std::array<int, 3> high = {0, 0, 0};

  bool is_empty() const { return low[0] >= high[0] || low[1] >= high[1] || low[2] >= high[2]; }
};

// A body of material as a signed distance field: a dense grid of floats, metres, positive outside, linear along each axis between the
// nodes. Distances are limited to a band of kBandVoxels spacings on both sides of the surface. A carve takes the capsule out of the body:
// field = max(field, -distance to the capsule). The order of carves does not matter, and a carve twice is a carve once, to the last bit.
// Outside the body a value is at most the distance to it (as a node has it, and rounding), also after carving: it bounds a safe step.
// Frame: the mesh's (the static scene S). Threads: one at a time.
class CarvedField {
 public:
  static constexpr int kBandVoxels = 3;
  static constexpr std::size_t kMostNodes = std::size_t{1} << 24;  // 64 MiB

  // The nodes that make() would use. Error, in one line: a mesh that is not closed, a voxel too small for kMostNodes or not positive. RT:
  // set-up only.
  static Result<FieldGrid> plan(const TriangleMesh& mesh, double voxel_m);
  // Error: that of plan(). RT: set-up only.
  static Result<CarvedField> make(const TriangleMesh& mesh, double voxel_m);

  // Result: the nodes changed whose old value was below two spacings, so that the surface or its normals may have changed; empty if none.
  // Time: proportional to the nodes within the capsule's box and the band. A carve that is not finite, or without a radius, changes
  // nothing. RT: yes.
  CarvedFieldBox carve(const Carve& carve) noexcept;

  // Whether carve() would return nodes. Time: as carve, mostly much less. RT: yes.
  bool would_change(const Carve& carve) const noexcept;

  // The signed distance, at most band_m(); outside the grid band_m() plus the distance to the grid. Continuous. RT: yes.
  double value(const Vec3& p) const noexcept;

  // The gradient by central differences over two spacings, continuous; about unit length near the surface, zero far inside. It points out
  // of the body. RT: yes.
  Vec3 gradient(const Vec3& p) const noexcept;

  const FieldGrid& grid() const noexcept { return grid_; }
  const Vec3& origin_m() const noexcept { return grid_.origin_m; }
  double spacing_m() const noexcept { return grid_.spacing_m; }
  const std::array<int, 3>& nodes() const noexcept { return grid_.nodes; }  // nodes()[0] is a multiple of 8
  double band_m() const noexcept { return band_m_; }

  // Of the nodes, x fastest (FieldGrid::index).
  std::span<const float> values() const noexcept { return {blocks_.front().lanes.data(), grid_.size()}; }

 private:
  struct alignas(32) Block {
    std::array<float, 8> lanes;
  };

  explicit CarvedField(const FieldGrid& grid);
  // visit(block, row's y and z, first node along x, carved): for each block of eight nodes that the capsule and its band can reach; it ends
  // where visit returns false.
  template <class Visit>
  void visit_reach(const Carve& carve, Visit&& visit) const noexcept;
  std::span<float> own_values() noexcept { return {blocks_.front().lanes.data(), grid_.size()}; }

  FieldGrid grid_;
  double per_spacing_ = 0.0;
  Vec3 last_ = Vec3::Zero();  // node, in spacings
  double band_m_ = 0.0;
  LargeVector<Block> blocks_;
};

}  // namespace hapton
