#include "vision_node/carved_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

// At an edge of the surface a coarser level lies about this far from the finest level, in steps of the coarser level's grid.
constexpr double kErrorInSteps = 0.5;
// Least cosine between a cone's axis and the normals: a cluster with normals in nearly all directions never shows only its back.
constexpr float kMinConeCosine = 0.1F;

Vec3f unit_or_up(const Vec3f& v) {
  const float length = v.norm();
  return length > 0.0F ? Vec3f(v / length) : Vec3f::UnitZ();
}

Vec3f normal_of(const std::vector<FlatVertex>& vertices, const std::uint32_t* corners) {
  const Vec3f& a = vertices[corners[0]].position;
  return unit_or_up((vertices[corners[1]].position - a).cross(vertices[corners[2]].position - a));
}

// Finds a cone as meshoptimizer does (its clusters have fewer triangles than a block may have): the apex is behind all triangles' planes.
void set_cone(const std::vector<FlatVertex>& vertices, const std::vector<std::uint32_t>& indices, DetailCluster& cluster) {
  Vec3f sum = Vec3f::Zero();
  for (std::size_t i = 0; i < indices.size(); i += 3) sum += normal_of(vertices, &indices[i]);
  const Vec3f axis = unit_or_up(sum);
  float min_cosine = 1.0F;
  for (std::size_t i = 0; i < indices.size(); i += 3) min_cosine = std::min(min_cosine, normal_of(vertices, &indices[i]).dot(axis));
  if (min_cosine <= kMinConeCosine) return;
  float farthest = 0.0F;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const Vec3f normal = normal_of(vertices, &indices[i]);
    farthest = std::max(farthest, (cluster.centre - vertices[indices[i]].position).dot(normal) / axis.dot(normal));
  }
  cluster.cone_apex = cluster.centre - farthest * axis;
  cluster.cone_axis = axis;
  cluster.cone_cutoff = std::sqrt(std::max(0.0F, 1.0F - min_cosine * min_cosine));
}

void bound(const std::vector<FlatVertex>& vertices, const std::vector<std::uint32_t>& indices, DetailCluster& cluster) {
  Eigen::AlignedBox3f box;
  for (const FlatVertex& vertex : vertices) box.extend(vertex.position);
  cluster.count = static_cast<std::uint32_t>(indices.size());
  cluster.centre = box.center();
  for (const FlatVertex& vertex : vertices) cluster.radius = std::max(cluster.radius, (vertex.position - cluster.centre).norm());
  set_cone(vertices, indices, cluster);
}

}  // namespace

CarvedSurface::CarvedSurface(CarvedField field, const DetailFrame& frame)
    : uncarved_field_(std::move(field)), field_(uncarved_field_), frame_(frame), block_counts_(SurfaceNets::count_blocks(field_.nodes())) {
  blocks_.resize(static_cast<std::size_t>(block_counts_[0]) * static_cast<std::size_t>(block_counts_[1]) *
                 static_cast<std::size_t>(block_counts_[2]));
}

void CarvedSurface::carve(const Carve& carve) { note_changed(field_.carve(carve)); }

void CarvedSurface::undo(const CarveList& list, int object, const CarveRange& undone) {
  note_changed(restore_undone(list, object, undone, uncarved_field_, field_));
}

void CarvedSurface::note_changed(const CarvedFieldBox& box) {
  if (box.is_empty()) return;
  const SurfaceNets::Blocks changed = SurfaceNets::find_changed(field_.nodes(), box.low, box.high);
  for (int z = changed.first[2]; z < changed.end[2]; ++z) {
    for (int y = changed.first[1]; y < changed.end[1]; ++y) {
      for (int x = changed.first[0]; x < changed.end[0]; ++x) {
        blocks_[static_cast<std::size_t>(x + block_counts_[0] * (y + block_counts_[1] * z))].has_changed = has_changed_ = true;
      }
    }
  }
}

void CarvedSurface::restore() {
  field_ = uncarved_field_;
  for (Block& block : blocks_) block.has_changed = true;
  has_changed_ = true;
}

std::vector<FlatLevel> CarvedSurface::compute_levels() {
  for (std::size_t number = 0; number < blocks_.size(); ++number) {
    if (std::exchange(blocks_[number].has_changed, false)) compute_block(number);
  }
  has_changed_ = false;
  std::vector<FlatLevel> levels;
  for (std::size_t level = 0; level < kStrides.size(); ++level) levels.push_back(join(level));
  return levels;
}

void CarvedSurface::compute_block(std::size_t number) {
  const auto block = static_cast<int>(number);
  const SurfaceNets::Index index = {block % block_counts_[0], block / block_counts_[0] % block_counts_[1],
                                    block / (block_counts_[0] * block_counts_[1])};
  for (std::size_t level = 0; level < kStrides.size(); ++level) {
    nets_.compute({field_.values(), field_.nodes()}, index, kStrides[level], net_);
    blocks_[number].pieces[level] = make_piece(net_);
  }
}

// Both triangles of a quad end at a vertex that only they have. It has the normal of the quad: the cross product of its diagonals. If each
// triangle had its own normal, the edge between them would show where the quad is bent.
CarvedSurface::Piece CarvedSurface::make_piece(const SurfaceNet& net) const {
  Piece piece;
  piece.vertices.reserve(net.positions.size() + net.quads.size());
  piece.indices.reserve(6 * net.quads.size());
  const Vec3f first = ((field_.origin_m() - frame_.centre) / frame_.scale_m).cast<float>();
  const auto step = static_cast<float>(field_.spacing_m() / frame_.scale_m);
  for (const Vec3f& p : net.positions) piece.vertices.push_back({first + step * p, 0});
  for (const std::array<std::uint32_t, 4>& quad : net.quads) {
    const auto corner = [&](std::size_t k) { return piece.vertices[quad[k]].position; };
    const Vec3f normal = unit_or_up((corner(2) - corner(0)).cross(corner(3) - corner(1)));
    const auto last = static_cast<std::uint32_t>(piece.vertices.size());
    piece.vertices.push_back({corner(0), pack_normal(normal)});
    for (const std::uint32_t index : {quad[1], quad[2], last, quad[2], quad[3], last}) piece.indices.push_back(index);
  }
  if (!piece.indices.empty()) bound(piece.vertices, piece.indices, piece.cluster);
  return piece;
}

FlatLevel CarvedSurface::join(std::size_t level) const {
  FlatLevel joined;
  std::size_t vertices = 0;
  std::size_t indices = 0;
  for (const Block& block : blocks_) {
    vertices += block.pieces[level].vertices.size();
    indices += block.pieces[level].indices.size();
  }
  joined.vertices.reserve(vertices);
  joined.indices.reserve(indices);
  for (const Block& block : blocks_) {
    const Piece& piece = block.pieces[level];
    if (piece.indices.empty()) continue;
    joined.clusters.push_back(piece.cluster);
    joined.clusters.back().first = static_cast<std::uint32_t>(joined.indices.size());
    const auto base = static_cast<std::uint32_t>(joined.vertices.size());
    joined.vertices.insert(joined.vertices.end(), piece.vertices.begin(), piece.vertices.end());
    for (const std::uint32_t index : piece.indices) joined.indices.push_back(base + index);
  }
  if (level > 0) joined.error = kErrorInSteps * kStrides[level] * field_.spacing_m() / frame_.scale_m;
  return joined;
}

}  // namespace hapton
