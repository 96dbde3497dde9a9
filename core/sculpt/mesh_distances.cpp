#include "core/sculpt/mesh_distances.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// Nodes first..last of one axis that lie in [low, high]; empty if last < first.
struct NodeRange {
  int first, last;
};

NodeRange nodes_between(const FieldGrid& grid, int axis, double low, double high) {
  const double most = grid.nodes[static_cast<std::size_t>(axis)] - 1.0;
  const double first = std::clamp(std::ceil((low - grid.origin_m[axis]) / grid.spacing_m), 0.0, most + 1.0);
  const double last = std::clamp(std::floor((high - grid.origin_m[axis]) / grid.spacing_m), -1.0, most);
  return {static_cast<int>(first), static_cast<int>(last)};
}

// add() lowers the values of nodes to their squared distance from a triangle; it reaches all nodes within the band of the triangle.
class TriangleRaster {
 public:
  TriangleRaster(const FieldGrid& grid, double band_m, std::span<float> squares) : grid_(grid), band_m_(band_m), squares_(squares) {}

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 low = a.cwiseMin(b).cwiseMin(c).array() - band_m_;
    const Vec3 high = a.cwiseMax(b).cwiseMax(c).array() + band_m_;
    const Vec3 cross = (b - a).cross(c - a);
    const Vec3 normal = cross.norm() > 0.0 ? cross.normalized() : Vec3::Zero();
    const NodeRange ys = nodes_between(grid_, 1, low.y(), high.y());
    const NodeRange zs = nodes_between(grid_, 2, low.z(), high.z());
    for (int z = zs.first; z <= zs.last; ++z) {
      for (int y = ys.first; y <= ys.last; ++y) {
        // The part of the row within the band of the triangle's plane.
        double from = low.x(), to = high.x();
        const double off = normal.dot(grid_.node(0, y, z) - a) - normal.x() * grid_.origin_m.x();
        if (std::abs(normal.x()) > kMinNormalX) {
          const double one = (-band_m_ - off) / normal.x(), two = (band_m_ - off) / normal.x();
          const double slack = grid_.spacing_m;
          from = std::max(from, std::min(one, two) - slack);
          to = std::min(to, std::max(one, two) + slack);
        }
        add_row(a, b, c, y, z, nodes_between(grid_, 0, from, to));
      }
    }
  }

 private:
  static constexpr double kMinNormalX = 1e-3;  // with a smaller one the plane is too nearly parallel to x to bound the row usefully

  void add_row(const Vec3& a, const Vec3& b, const Vec3& c, int y, int z, NodeRange xs) {
    const auto fill = [](const Vec3& p) {
      return detail::Of3<Lanes4>{detail::fill<Lanes4>(p.x()), detail::fill<Lanes4>(p.y()), detail::fill<Lanes4>(p.z())};
    };
    const auto fa = fill(a), fb = fill(b), fc = fill(c);
    float* row = squares_.data() + grid_.index(0, y, z);
    for (int x = xs.first & ~3; x <= xs.last; x += 4) {
      auto p = fill(grid_.node(0, y, z));
      p.x = Lanes4{0.0, 1.0, 2.0, 3.0} * grid_.spacing_m + (grid_.origin_m.x() + grid_.spacing_m * x);
      const Lanes4 squared = triangle_distance_squared<Lanes4>(p, fa, fb, fc);
      for (int lane = 0; lane < 4; ++lane) row[x + lane] = std::min(row[x + lane], static_cast<float>(squared[lane]));
    }
  }

  const FieldGrid& grid_;
  double band_m_;
  std::span<float> squares_;
};

// Where the rows of nodes along x pass through the surface. The y and z of vertices and rows are rounded to whole numbers, 2^26 to the
// extent of the mesh. So the side of an edge on which a row passes is exact, and a row never passes through a vertex, as vertices have even
// numbers and rows odd ones. A row through an edge counts as beside it, on the same side for both its triangles (Edelsbrunner & Muecke,
// Simulation of simplicity, 1990).
class RowCrossings {
 public:
  RowCrossings(const TriangleMesh& mesh, const FieldGrid& grid) : mesh_(mesh), grid_(grid) {
    const MeshBounds bounds = compute_bounds(mesh);
    middle_ = bounds.centre();
    scale_ = kSteps / std::max(bounds.extent(), grid.spacing_m);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) add_triangle(i);
    std::sort(crossings_.begin(), crossings_.end(),
              [](const Crossing& a, const Crossing& b) { return a.row != b.row ? a.row < b.row : a.x_m < b.x_m; });
  }

  // Makes the values of the nodes inside negative.
  void set_signs(std::span<float> values) const {
    for (std::size_t i = 0; i < crossings_.size();) {
      std::size_t end = i;
      while (end < crossings_.size() && crossings_[end].row == crossings_[i].row) ++end;
      float* row = values.data() + crossings_[i].row * static_cast<std::size_t>(grid_.nodes[0]);
      int winding = 0;
      for (; i < end; ++i) {
        winding += crossings_[i].sign;
        if (winding == 0 || i + 1 == end) continue;
        const NodeRange inside = nodes_between(grid_, 0, crossings_[i].x_m, crossings_[i + 1].x_m);
        for (int x = inside.first; x <= inside.last; ++x) row[x] = -std::abs(row[x]);
      }
    }
  }

 private:
  static constexpr double kSteps = 1 << 25;  // steps of two whole numbers each, to the extent: products of two numbers fit into 64 bits

  struct Crossing {
    std::size_t row;
    double x_m;
    int sign;
  };
  struct Place {
    std::int64_t y, z;
  };

  Place to_even_place(const Vec3& p) const { return {2 * rounded_step(p, 1), 2 * rounded_step(p, 2)}; }
  std::int64_t rounded_step(const Vec3& p, int axis) const { return std::llround((p[axis] - middle_[axis]) * scale_); }

  // Twice the area of (p, from, to), exact. Where it is 0, `sign` is that for p moved a little towards +y and much less towards +z.
  struct Side {
    std::int64_t area;
    int sign;
  };
  static Side side(const Place& p, const Place& from, const Place& to) {
    const std::int64_t dy = to.y - from.y, dz = to.z - from.z;
    const std::int64_t area = dy * (p.z - from.z) - dz * (p.y - from.y);
    const std::int64_t first_nonzero = area != 0 ? area : dz != 0 ? -dz : dy;
    return {area, first_nonzero > 0 ? 1 : first_nonzero < 0 ? -1 : 0};
  }

  void add_triangle(std::size_t triangle) {
    const Vec3 &a = mesh_.corner(triangle, 0), &b = mesh_.corner(triangle, 1), &c = mesh_.corner(triangle, 2);
    const Place pa = to_even_place(a), pb = to_even_place(b), pc = to_even_place(c);
    const double slack = 4.0 / scale_;  // more than vertices (0.5) and rows (1) move by rounding
    const Vec3 low = a.cwiseMin(b).cwiseMin(c).array() - slack, high = a.cwiseMax(b).cwiseMax(c).array() + slack;
    const NodeRange ys = nodes_between(grid_, 1, low.y(), high.y());
    const NodeRange zs = nodes_between(grid_, 2, low.z(), high.z());
    for (int z = zs.first; z <= zs.last; ++z) {
      for (int y = ys.first; y <= ys.last; ++y) {
        const Place even_p = to_even_place(grid_.node(0, y, z));
        const Place p = {even_p.y + 1, even_p.z + 1};
        const Side wa = side(p, pb, pc), wb = side(p, pc, pa), wc = side(p, pa, pb);
        if (wa.sign == 0 || wa.sign != wb.sign || wb.sign != wc.sign) continue;
        const auto area = static_cast<double>(wa.area + wb.area + wc.area);
        const double x =
            area == 0.0 ? a.x()
                        : a.x() + (static_cast<double>(wb.area) * (b.x() - a.x()) + static_cast<double>(wc.area) * (c.x() - a.x())) / area;
        const std::size_t row = static_cast<std::size_t>(z) * static_cast<std::size_t>(grid_.nodes[1]) + static_cast<std::size_t>(y);
        crossings_.push_back({row, x, wa.sign});
      }
    }
  }

  const TriangleMesh& mesh_;
  const FieldGrid& grid_;
  Vec3 middle_ = Vec3::Zero();
  double scale_ = 1.0;
  std::vector<Crossing> crossings_;
};

}  // namespace

void compute_mesh_distances(const TriangleMesh& mesh, const FieldGrid& grid, double band_m, std::span<float> values) {
  const auto band = static_cast<float>(band_m);
  std::fill(values.begin(), values.end(), band * band);
  TriangleRaster raster(grid, band_m, values);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) raster.add(mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2));
  for (float& value : values) value = std::min(std::sqrt(value), band);
  RowCrossings(mesh, grid).set_signs(values);
}

}  // namespace hapton
