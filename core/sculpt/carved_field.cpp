#include "core/sculpt/carved_field.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/geometry/mesh_measures.h"
#include "core/math/float8.h"
#include "core/sculpt/mesh_distances.h"

namespace hapton {
namespace {

// Distance from the mesh to the border of the grid: beyond the band, so that all values at the border are +band.
constexpr int kMarginVoxels = CarvedField::kBandVoxels + 1;
constexpr double kMaxNodesOfAxis = 1 << 20;  // keeps the number within an int; with so many nodes along one axis, a grid exceeds kMaxNodes

// A row of nodes along x consists of blocks of eight, the lanes of a Float8.
constexpr int round_up_to_block(int nodes) { return (nodes + 7) & ~7; }

// The nodes, along each axis, whose values a carve can change; empty if last < first.
struct CarveReach {
  std::array<int, 3> first, last;

  CarveReach(const FieldGrid& grid, const Carve& carve, double reach_m) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const double most = grid.nodes[i] - 1.0;
      const double low = (std::min(carve.from_m[axis], carve.to_m[axis]) - reach_m - grid.origin_m[axis]) / grid.spacing_m;
      const double high = (std::max(carve.from_m[axis], carve.to_m[axis]) + reach_m - grid.origin_m[axis]) / grid.spacing_m;
      first[i] = static_cast<int>(std::clamp(std::ceil(low), 0.0, most + 1.0));
      last[i] = static_cast<int>(std::clamp(std::floor(high), -1.0, most));
    }
  }
};

// The capsule relative to from_m, in single precision.
struct CapsuleLanes {
  explicit CapsuleLanes(const Carve& carve)
      : along((carve.to_m - carve.from_m).cast<float>()),
        inverse_squared(along.squaredNorm() > 0.0F ? 1.0F / along.squaredNorm() : 0.0F),
        radius(static_cast<float>(carve.radius_m)) {}

  // How deep a point lies below the capsule's surface: positive inside, negative outside.
  Float8 depth(Float8 x, float y, float z) const noexcept {
    const Float8 dot = x * Float8(along.x()) + Float8(y * along.y() + z * along.z());
    const Float8 share = min(Float8(1.0F), max(Float8(0.0F), dot * Float8(inverse_squared)));
    const Float8 dx = x - share * Float8(along.x());
    const Float8 dy = Float8(y) - share * Float8(along.y());
    const Float8 dz = Float8(z) - share * Float8(along.z());
    return Float8(radius) - sqrt(dx * dx + dy * dy + dz * dz);
  }

  Eigen::Vector3f along;
  float inverse_squared;
  float radius;
};

void extend(CarvedFieldBox& box, int x_first, int x_last, int y, int z) {
  const std::array<int, 3> low = {x_first, y, z}, high = {x_last + 1, y + 1, z + 1};
  const bool is_first = box.is_empty();
  for (std::size_t i = 0; i < 3; ++i) {
    box.low[i] = is_first ? low[i] : std::min(box.low[i], low[i]);
    box.high[i] = is_first ? high[i] : std::max(box.high[i], high[i]);
  }
}

bool is_capsule(const Carve& carve) {
  return carve.from_m.allFinite() && carve.to_m.allFinite() && carve.radius_m > 0.0 && std::isfinite(carve.radius_m);
}

double squared_distance_across_x(const Carve& carve, double y, double z) {
  const Eigen::Vector2d from(carve.from_m.y(), carve.from_m.z());
  const Eigen::Vector2d along(carve.to_m.y() - from.x(), carve.to_m.z() - from.y());
  const Eigen::Vector2d off = Eigen::Vector2d(y, z) - from;
  const double square = along.squaredNorm();
  const double share = square > 0.0 ? std::clamp(off.dot(along) / square, 0.0, 1.0) : 0.0;
  return (off - share * along).squaredNorm();
}

}  // namespace

CarvedField::CarvedField(const FieldGrid& grid)
    : grid_(grid),
      per_spacing_(1.0 / grid.spacing_m),
      last_node_(Vec3(grid.nodes[0], grid.nodes[1], grid.nodes[2]).array() - 1.0),
      band_m_(kBandVoxels * grid.spacing_m),
      blocks_(grid.size() / 8) {}

Result<FieldGrid> CarvedField::plan(const TriangleMesh& mesh, double voxel_m) {
  if (!(voxel_m > 0.0) || !std::isfinite(voxel_m)) return fail("a voxel of {} m: give it a size above 0", voxel_m);
  const EdgeCensus edges = count_edges(mesh);
  if (!edges.closed()) {
    return fail("the mesh is not closed ({} boundary, {} non-manifold and {} flipped edges), so it has no inside: repair it",
                edges.boundary, edges.non_manifold, edges.inconsistent);
  }
  const MeshBounds bounds = compute_bounds(mesh);
  FieldGrid grid{.origin_m = Vec3::Zero(), .spacing_m = voxel_m, .nodes = {}};
  double count = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = std::ceil((bounds.high[axis] - bounds.low[axis]) / voxel_m) + 2.0 * kMarginVoxels;
    const int nodes = static_cast<int>(std::min(cells, kMaxNodesOfAxis)) + 1;
    const auto i = static_cast<std::size_t>(axis);
    grid.nodes[i] = axis == 0 ? round_up_to_block(nodes) : nodes;
    grid.origin_m[axis] = bounds.centre()[axis] - 0.5 * voxel_m * (grid.nodes[i] - 1);
    count *= grid.nodes[i];
  }
  if (count > static_cast<double>(kMaxNodes)) {
    return fail("voxels of {:.4g} mm would be {:.3g} million, at most {} are possible: give voxels of {:.2g} mm or more", 1e3 * voxel_m,
                1e-6 * count, kMaxNodes >> 20, 1e3 * voxel_m * 1.05 * std::cbrt(count / static_cast<double>(kMaxNodes)));
  }
  return grid;
}

Result<CarvedField> CarvedField::make(const TriangleMesh& mesh, double voxel_m) {
  const auto grid = plan(mesh, voxel_m);
  if (!grid) return tl::unexpected(grid.error());
  CarvedField field(*grid);
  compute_mesh_distances(mesh, *grid, field.band_m_, field.mutable_values());
  return field;
}

template <class Visit>
void CarvedField::visit_reach(const Carve& unrounded, const CarvedFieldBox& within, Visit&& visit) const noexcept {
  const Carve carve = rounded(unrounded);
  if (!is_capsule(carve)) return;
  const double reach_m = carve.radius_m + band_m_;
  CarveReach reach(grid_, carve, reach_m);
  for (std::size_t i = 0; i < 3; ++i) {
    reach.first[i] = std::max(reach.first[i], within.low[i]);
    reach.last[i] = std::min(reach.last[i], within.high[i] - 1);
  }
  const CapsuleLanes capsule(carve);
  const Float8 band(static_cast<float>(band_m_));
  alignas(32) static constexpr std::array<float, 8> kLanes = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int z = reach.first[2]; z <= reach.last[2]; ++z) {
    for (int y = reach.first[1]; y <= reach.last[1]; ++y) {
      const Vec3 begin = grid_.node(0, y, z);
      if (squared_distance_across_x(carve, begin.y(), begin.z()) > reach_m * reach_m) continue;
      const Eigen::Vector3f off = (begin - carve.from_m).cast<float>();
      const std::size_t row = grid_.index(0, y, z) / 8;
      for (int block = reach.first[0] / 8; 8 * block <= reach.last[0]; ++block) {
        const Float8 number = Float8::load(kLanes.data()) + Float8(static_cast<float>(8 * block));
        const Float8 x = Float8(off.x()) + number * Float8(static_cast<float>(grid_.spacing_m));
        const Float8 carved = min(band, capsule.depth(x, off.y(), off.z()));
        if (!visit(row + static_cast<std::size_t>(block), y, z, 8 * block, carved)) return;
      }
    }
  }
}

CarvedFieldBox CarvedField::carve(const Carve& carve) noexcept {
  CarvedFieldBox changed;
  const Float8 near(static_cast<float>(2.0 * grid_.spacing_m));
  visit_reach(carve, all_nodes(), [&](std::size_t block, int y, int z, int x, Float8 carved) {
    const Float8 old = Float8::load(blocks_[block].lanes.data());
    store(blocks_[block].lanes.data(), max(carved, old));
    const unsigned lanes = sign_bits((carved > old) & (old < near));
    if (lanes != 0) extend(changed, x + std::countr_zero(lanes), x + static_cast<int>(std::bit_width(lanes)) - 1, y, z);
    return true;
  });
  return changed;
}

bool CarvedField::would_change(const Carve& carve) const noexcept {
  bool changes = false;
  const Float8 near(static_cast<float>(2.0 * grid_.spacing_m));
  visit_reach(carve, all_nodes(), [&](std::size_t block, int, int, int, Float8 carved) {
    const Float8 old = Float8::load(blocks_[block].lanes.data());
    changes = sign_bits((carved > old) & (old < near)) != 0;
    return !changes;
  });
  return changes;
}

CarvedFieldBox CarvedField::reach(const Carve& unrounded) const noexcept {
  const Carve carve = rounded(unrounded);
  if (!is_capsule(carve)) return {};
  const CarveReach reach(grid_, carve, carve.radius_m + band_m_);
  CarvedFieldBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    if (reach.last[i] < reach.first[i]) return {};
    box.low[i] = i == 0 ? reach.first[i] & ~7 : reach.first[i];
    box.high[i] = i == 0 ? round_up_to_block(reach.last[i] + 1) : reach.last[i] + 1;
  }
  return box;
}

void CarvedField::carve_within(const Carve& carve, const CarvedFieldBox& box) noexcept {
  visit_reach(carve, box, [&](std::size_t block, int, int, int, Float8 carved) {
    store(blocks_[block].lanes.data(), max(carved, Float8::load(blocks_[block].lanes.data())));
    return true;
  });
}

void CarvedField::copy(const CarvedField& other, const CarvedFieldBox& box) noexcept {
  const int length = box.high[0] - box.low[0];
  for (int z = box.low[2]; z < box.high[2]; ++z) {
    for (int y = box.low[1]; y < box.high[1]; ++y) {
      const std::size_t row = grid_.index(box.low[0], y, z);
      std::copy_n(other.values().begin() + static_cast<std::ptrdiff_t>(row), length,
                  mutable_values().begin() + static_cast<std::ptrdiff_t>(row));
    }
  }
}

double CarvedField::value(const Vec3& p) const noexcept {
  const Vec3 cell = (p - grid_.origin_m) * per_spacing_;
  const Vec3& last = last_node_;
  const Vec3 inside = cell.cwiseMax(0.0).cwiseMin(last);
  const double outside = (cell - inside).squaredNorm();
  if (!(outside <= 0.0)) return band_m_ + grid_.spacing_m * std::sqrt(outside);
  const int x = std::min(static_cast<int>(inside.x()), grid_.nodes[0] - 2);
  const int y = std::min(static_cast<int>(inside.y()), grid_.nodes[1] - 2);
  const int z = std::min(static_cast<int>(inside.z()), grid_.nodes[2] - 2);
  const Vec3 share = inside - Vec3(x, y, z);
  const float* low = values().data() + grid_.index(x, y, z);
  const float* high = low + grid_.index(0, 0, 1);
  const auto row = static_cast<std::size_t>(grid_.nodes[0]);
  const auto along_x = [&](const float* from) { return from[0] + share.x() * (static_cast<double>(from[1]) - from[0]); };
  const auto along_y = [&](const float* from) {
    const double near = along_x(from);
    return near + share.y() * (along_x(from + row) - near);
  };
  const double near = along_y(low);
  return near + share.z() * (along_y(high) - near);
}

Vec3 CarvedField::gradient(const Vec3& p) const noexcept {
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = grid_.spacing_m * Vec3::Unit(axis);
    gradient[axis] = (value(p + step) - value(p - step)) / (2.0 * grid_.spacing_m);
  }
  return gradient;
}

}  // namespace hapton
