#include "core/sculpt/manifold_surface.h"

#include <cstddef>
#include <numeric>
#include <utility>

namespace hapton {
namespace {

// Numbers in a cell: corner x + 2 y + 4 z is at (x, y, z). Edge 4 axis + n is parallel to the axis and begins at the corner that is (n & 1)
// along the next axis and (n >> 1) along the axis after that. Face 2 axis + side is at that side (0 or 1) along the axis.
constexpr std::size_t kEdges = 12;
constexpr std::size_t kFaces = 6;
constexpr std::uint8_t kNoPiece = 0xFF;

std::size_t next_axis(std::size_t axis) { return (axis + 1) % 3; }
std::size_t corner_step(std::size_t axis) { return std::size_t{1} << axis; }
bool is_inside(unsigned corners, std::size_t corner) { return (corners >> corner & 1U) != 0; }

// The pieces of surface in a cell.
struct CellPieces {
  std::array<std::uint8_t, kEdges> of_edge;  // kNoPiece: the surface does not cross the edge
  std::uint8_t count = 0;
};

// A face, its corners counter-clockwise about its axis; edge k goes from corner k to the next one.
struct CellFace {
  std::array<std::size_t, 4> corners;
  std::array<std::size_t, 4> edges;
};

CellFace face_of(std::size_t axis, std::size_t side) {
  const std::size_t u = next_axis(axis);
  const std::size_t v = next_axis(u);
  const std::size_t first = side * corner_step(axis);
  return {{first, first + corner_step(u), first + corner_step(u) + corner_step(v), first + corner_step(v)},
          {4 * u + 2 * side, 4 * v + side + 2, 4 * u + 1 + 2 * side, 4 * v + side}};
}

std::size_t edge_begin(std::size_t edge) {
  const std::size_t second = next_axis(edge / 4);
  return (edge & 1U) * corner_step(second) + (edge >> 1U & 1U) * corner_step(next_axis(second));
}

// True if the corners alternate between inside and outside: then two pieces of contour are in the face.
bool is_ambiguous(const CellFace& face, unsigned corners) {
  const auto inside = [&](std::size_t k) { return is_inside(corners, face.corners[k]); };
  return inside(0) != inside(1) && inside(1) != inside(2) && inside(2) != inside(3);
}

// flips: bit f is for face f, if that is ambiguous. If it is set, the contour in the face separates the two outside corners from each
// other, and if not, the two inside corners.
CellPieces find_pieces(unsigned corners, unsigned flips) {
  std::array<std::size_t, kEdges> root;
  std::iota(root.begin(), root.end(), 0);
  const auto join = [&](std::size_t a, std::size_t b) {
    const std::size_t from = root[a];
    for (std::size_t& each : root) each = each == from ? root[b] : each;
  };
  const auto crosses = [&](std::size_t edge) {
    const std::size_t begin = edge_begin(edge);
    return is_inside(corners, begin) != is_inside(corners, begin + corner_step(edge / 4));
  };
  for (std::size_t f = 0; f < kFaces; ++f) {
    const CellFace face = face_of(f / 2, f % 2);
    if (is_ambiguous(face, corners)) {
      const bool cuts_inside = (flips >> f & 1U) == 0;
      for (std::size_t k = 0; k < 4; ++k) {
        if (is_inside(corners, face.corners[k]) == cuts_inside) join(face.edges[(k + 3) % 4], face.edges[k]);
      }
      continue;
    }
    std::size_t first = kEdges;
    for (const std::size_t edge : face.edges) {
      if (!crosses(edge)) continue;
      if (first != kEdges) join(first, edge);
      first = edge;
    }
  }
  CellPieces pieces;
  std::array<std::uint8_t, kEdges> number;
  number.fill(kNoPiece);
  for (std::size_t edge = 0; edge < kEdges; ++edge) {
    pieces.of_edge[edge] = kNoPiece;
    if (!crosses(edge)) continue;
    if (number[root[edge]] == kNoPiece) number[root[edge]] = pieces.count++;
    pieces.of_edge[edge] = number[root[edge]];
  }
  return pieces;
}

class ManifoldSurfaceMaker {
 public:
  explicit ManifoldSurfaceMaker(const NodeValues& grid)
      : grid_(grid), steps_{1, static_cast<std::size_t>(grid.counts[0]), static_cast<std::size_t>(grid.counts[0] * grid.counts[1])} {
    for (unsigned corners = 0; corners < unflipped_pieces_.size(); ++corners) unflipped_pieces_[corners] = find_pieces(corners, 0);
    for (auto* layer : {&layer_below_, &present_layer_}) layer->resize(step(2));
  }

  // Works layer by layer along z: the cells around an edge of the grid are in two layers at most.
  ManifoldSurface make() {
    for (cell_[2] = 0; cell_[2] + 1 < grid_.counts[2]; ++cell_[2]) {
      std::swap(layer_below_, present_layer_);
      for_each_node([this](std::size_t node) { place_vertices(node); });
      for_each_node([this](std::size_t node) { join_quads(node); });
    }
    return std::move(surface_);
  }

 private:
  struct Cell {
    std::uint32_t first = 0;  // number of its first vertex
    CellPieces pieces;
  };

  std::size_t step(std::size_t axis) const { return steps_[axis]; }
  template <class Function>
  void for_each_node(Function&& function) {
    for (cell_[1] = 0; cell_[1] + 1 < grid_.counts[1]; ++cell_[1]) {
      const std::size_t row = static_cast<std::size_t>(cell_[1]) * step(1) + static_cast<std::size_t>(cell_[2]) * step(2);
      for (cell_[0] = 0; cell_[0] + 1 < grid_.counts[0]; ++cell_[0]) function(row + static_cast<std::size_t>(cell_[0]));
    }
  }
  // Which corners of the cell are inside, one bit each.
  unsigned corners_of(std::size_t node) const {
    unsigned corners = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) corners |= (grid_.values[corner_node(node, corner)] < 0.0F ? 1U : 0U) << corner;
    return corners;
  }
  std::size_t corner_node(std::size_t node, std::size_t corner) const {
    return node + (corner & 1U) + (corner >> 1U & 1U) * step(1) + (corner >> 2U) * step(2);
  }
  // True if both pieces of contour in the face belong to one piece of surface.
  bool is_joined(unsigned corners, const CellFace& face) const {
    const CellPieces& pieces = unflipped_pieces_[corners];
    return pieces.of_edge[face.edges[0]] == pieces.of_edge[face.edges[2]] &&
           pieces.of_edge[face.edges[1]] == pieces.of_edge[face.edges[3]] && pieces.of_edge[face.edges[0]] == pieces.of_edge[face.edges[1]];
  }
  // Faces in which the contour is changed. If both its pieces belong to one piece of surface in both cells, four triangles would meet in
  // one edge.
  unsigned find_flips(std::size_t node, unsigned corners) const {
    unsigned flips = 0;
    for (std::size_t f = 0; f < kFaces; ++f) {
      const CellFace face = face_of(f / 2, f % 2);
      if (!is_ambiguous(face, corners) || !is_joined(corners, face)) continue;
      // The corners at the border of the grid are outside, so there is a cell beyond the face.
      const std::size_t beyond = f % 2 == 0 ? node - step(f / 2) : node + step(f / 2);
      if (is_joined(corners_of(beyond), face_of(f / 2, 1 - f % 2))) flips |= 1U << f;
    }
    return flips;
  }

  void place_vertices(std::size_t node) {
    const unsigned corners = corners_of(node);
    if (unflipped_pieces_[corners].count == 0) return;
    const unsigned flips = find_flips(node, corners);
    Cell& cell = present_layer_[node - static_cast<std::size_t>(cell_[2]) * step(2)];
    cell.first = static_cast<std::uint32_t>(surface_.positions.size());
    cell.pieces = flips == 0 ? unflipped_pieces_[corners] : find_pieces(corners, flips);
    for (std::uint8_t piece = 0; piece < cell.pieces.count; ++piece) place_vertex(node, cell.pieces, piece);
  }

  // Sums in the order of SurfaceNets, so that vertices that both make are equal to the last bit.
  void place_vertex(std::size_t node, const CellPieces& pieces, std::uint8_t piece) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int crossings = 0;
    for (std::size_t edge = 0; edge < kEdges; ++edge) {
      if (pieces.of_edge[edge] != piece) continue;
      const std::size_t axis = edge / 4;
      const std::size_t from = corner_node(node, edge_begin(edge));
      const float a = grid_.values[from];
      const float b = grid_.values[from + step(axis)];
      sum[static_cast<Eigen::Index>(axis)] += a / (a - b);
      sum[static_cast<Eigen::Index>(next_axis(axis))] += static_cast<float>(edge & 1U);
      sum[static_cast<Eigen::Index>(next_axis(next_axis(axis)))] += static_cast<float>(edge >> 1U & 1U);
      ++crossings;
    }
    const Eigen::Vector3f whole(static_cast<float>(cell_[0]), static_cast<float>(cell_[1]), static_cast<float>(cell_[2]));
    surface_.positions.emplace_back(whole + sum / static_cast<float>(crossings));
  }

  // Makes a quad around each edge of the grid that begins at the node and is crossed by the surface.
  void join_quads(std::size_t node) {
    const bool is_node_inside = grid_.values[node] < 0.0F;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((grid_.values[node + step(axis)] < 0.0F) == is_node_inside) continue;
      std::array<std::uint32_t, 4> quad;
      for (std::size_t k = 0; k < 4; ++k) {
        constexpr std::array<std::size_t, 4> kEdgeNumbers = {3, 2, 0, 1};  // the number n of the edge in the cells around it
        quad[is_node_inside ? k : 3 - k] = vertex_at(node, axis, kEdgeNumbers[k]);
      }
      surface_.quads.push_back(quad);
    }
  }

  // The vertex in the cell in which the edge from the node along the axis has the number 4 axis + n.
  std::uint32_t vertex_at(std::size_t node, std::size_t axis, std::size_t n) const {
    const std::size_t second = next_axis(axis);
    const std::size_t third = next_axis(second);
    std::array<std::size_t, 3> back = {0, 0, 0};
    back[second] = n & 1U;
    back[third] = n >> 1U;
    const std::size_t in_layer = node - static_cast<std::size_t>(cell_[2]) * step(2) - back[0] - back[1] * step(1);
    const Cell& cell = (back[2] == 0 ? present_layer_ : layer_below_)[in_layer];
    return cell.first + cell.pieces.of_edge[4 * axis + n];
  }

  const NodeValues& grid_;
  std::array<std::size_t, 3> steps_;              // index step from a node to the next one along each axis
  std::array<CellPieces, 256> unflipped_pieces_;  // pieces without flips, by the corners that are inside
  std::vector<Cell> layer_below_;                 // cells of the layer below, by the number of their first node in the layer
  std::vector<Cell> present_layer_;               // cells of the present layer; valid where the surface passes
  std::array<int, 3> cell_ = {0, 0, 0};           // the present cell, or node
  ManifoldSurface surface_;
};

}  // namespace

ManifoldSurface make_manifold_surface(const NodeValues& grid) { return ManifoldSurfaceMaker(grid).make(); }

}  // namespace hapton
