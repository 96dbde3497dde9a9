#include "bench/measure/own_structures.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "bench/measure/triangle_tests.h"
#include "core/collision/fdh_tree.h"
#include "core/collision/touch_geometry.h"
#include "core/collision/uniform_grid.h"
#include "core/collision/visit_stamps.h"
#include "core/collision/wide_bvh.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

using Made = Result<std::unique_ptr<QueryStructure>>;

std::array<Vec3, 3> corners_of(const TriangleMesh& mesh, std::size_t i) {
  return {mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2)};
}

// Every structure except brute force and Fdh::nearest collects candidate triangles and tests them with these two structs.
struct FirstHit {
  const TriangleMesh& mesh;
  const Vec3& from;
  Vec3 motion;
  double t = kNothingFound;

  void test(std::uint32_t triangle) {
    t = std::min(t, segment_hit<double>(from, motion, mesh.corner(triangle, 0), mesh.corner(triangle, 1), mesh.corner(triangle, 2)));
  }
};

struct Nearest {
  const TriangleMesh& mesh;
  const Vec3& p;
  double squared;
  bool found = false;

  void test(std::uint32_t triangle) {
    const double d = point_distance_squared<double>(p, mesh.corner(triangle, 0), mesh.corner(triangle, 1), mesh.corner(triangle, 2));
    if (d > squared) return;
    squared = d;
    found = true;
  }
  double distance() const { return found ? std::sqrt(squared) : kNothingFound; }
};

template <class Real>
class Brute final : public QueryStructure {
 public:
  explicit Brute(const TriangleMesh& mesh) {
    corners_.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [a, b, c] = corners_of(mesh, i);
      corners_.push_back({a.template cast<Real>(), b.template cast<Real>(), c.template cast<Real>()});
    }
  }
  double first_hit(const Vec3& from, const Vec3& to) override {
    const Point3<Real> p = from.template cast<Real>();
    const Point3<Real> motion = (to - from).template cast<Real>();
    Real t = std::numeric_limits<Real>::infinity();
    for (const auto& [a, b, c] : corners_) t = std::min(t, segment_hit<Real>(p, motion, a, b, c));
    return static_cast<double>(t);
  }
  double nearest(const Vec3& p, double radius) override {
    const Point3<Real> q = p.template cast<Real>();
    Real least = std::numeric_limits<Real>::infinity();
    for (const auto& [a, b, c] : corners_) least = std::min(least, point_distance_squared<Real>(q, a, b, c));
    const double distance = std::sqrt(static_cast<double>(least));
    return distance <= radius ? distance : kNothingFound;
  }
  std::size_t bytes() const override { return corners_.capacity() * sizeof(corners_[0]); }

 private:
  std::vector<std::array<Point3<Real>, 3>> corners_;
};

// first_hit() tests the segment against the triangles in all cells that its bounding box covers, as method `sweep` does. nearest() searches
// a cube around the point, which grows until no triangle outside it can be nearer.
class Grid final : public QueryStructure {
 public:
  static Made make(const TriangleMesh& mesh, int division) {
    std::vector<std::array<Vec3, 3>> triangles(mesh.triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) triangles[i] = corners_of(mesh, i);
    auto grid = UniformGrid::make(triangles, {division, division, division});
    if (!grid) return tl::unexpected(grid.error());
    return std::make_unique<Grid>(mesh, std::move(*grid));
  }
  Grid(const TriangleMesh& mesh, UniformGrid grid) : mesh_(mesh), grid_(std::move(grid)), stamps_(mesh.triangles.size()) {
    const Vec3 size = grid_.high() - grid_.low();
    cell_ = size.maxCoeff() / grid_.division()[0];
  }
  double first_hit(const Vec3& from, const Vec3& to) override {
    FirstHit hit{mesh_, from, to - from};
    visit_cells(from.cwiseMin(to), from.cwiseMax(to), [&](std::uint32_t triangle) { hit.test(triangle); });
    return hit.t;
  }
  double nearest(const Vec3& p, double radius) override {
    for (double half_side = std::min(radius, 0.5 * cell_);; half_side = std::min(radius, 2.0 * half_side)) {
      Nearest near{mesh_, p, half_side * half_side};
      const Vec3 cube = Vec3::Constant(half_side);
      visit_cells(p - cube, p + cube, [&](std::uint32_t triangle) { near.test(triangle); });
      if (near.found || half_side >= radius) return near.distance();
    }
  }
  std::size_t bytes() const override {
    return (grid_.occupancy().cells + 1 + grid_.occupancy().entries + mesh_.triangles.size()) * sizeof(std::uint32_t);
  }

 private:
  template <class Visit>
  void visit_cells(const Vec3& low, const Vec3& high, Visit&& visit) {
    const CellBox box = grid_.find_cells(low, high);
    stamps_.start();
    for (int z = box.begin[2]; z < box.end[2]; ++z) {
      for (int y = box.begin[1]; y < box.end[1]; ++y) {
        for (int x = box.begin[0]; x < box.end[0]; ++x) {
          for (const std::uint32_t triangle : grid_.triangles_in(x, y, z)) {
            if (stamps_.first_visit(triangle)) visit(triangle);
          }
        }
      }
    }
  }

  const TriangleMesh& mesh_;
  UniformGrid grid_;
  VisitStamps stamps_;
  double cell_ = 0.0;
};

template <int K>
class Fdh final : public QueryStructure {
 public:
  static Made make(const TriangleMesh& mesh) {
    auto tree = FdhTree<K>::build(mesh.vertices, mesh.triangles);
    if (!tree) return tl::unexpected(tree.error());
    return std::make_unique<Fdh>(mesh, std::move(*tree));
  }
  Fdh(const TriangleMesh& mesh, FdhTree<K> tree) : mesh_(mesh), tree_(std::move(tree)) {}
  double first_hit(const Vec3& from, const Vec3& to) override {
    FirstHit hit{mesh_, from, to - from};
    tree_.for_each_overlapping(FdhSweep{from, to, 0.0}, [&](std::uint32_t triangle) { hit.test(triangle); });
    return hit.t;
  }
  double nearest(const Vec3& p, double radius) override { return std::sqrt(tree_.find_nearest(p, radius).distance_squared); }
  std::size_t bytes() const override { return tree_.stats().bytes; }

 private:
  const TriangleMesh& mesh_;
  FdhTree<K> tree_;
};

class Wide final : public QueryStructure {
 public:
  explicit Wide(const TriangleMesh& mesh) : mesh_(mesh), origin_(compute_bounds(mesh).centre()), tree_(boxes_of(mesh, origin_)) {}
  double first_hit(const Vec3& from, const Vec3& to) override {
    FirstHit hit{mesh_, from, to - from};
    tree_.for_each_overlapping(Box::around(from - origin_, to - origin_), [&](std::uint32_t triangle) { hit.test(triangle); });
    return hit.t;
  }
  double nearest(const Vec3& p, double radius) override {
    Nearest near{mesh_, p, radius * radius};
    tree_.visit_nearest(p - origin_, near.squared * (1.0 + 1e-12), [&](std::uint32_t triangle, double bound) {
      near.test(triangle);
      return std::min(bound, near.squared);
    });
    return near.distance();
  }
  std::size_t bytes() const override { return tree_.bytes(); }

 private:
  static std::vector<Box> boxes_of(const TriangleMesh& mesh, const Vec3& origin) {
    std::vector<Box> boxes(mesh.triangles.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      for (int k = 0; k < 3; ++k) boxes[i].grow(mesh.corner(i, k) - origin);
    }
    return boxes;
  }

  const TriangleMesh& mesh_;
  Vec3 origin_;
  WideBvh tree_;
};

template <class Structure>
Made make_plain(const TriangleMesh& mesh) {
  return std::make_unique<Structure>(mesh);
}

}  // namespace

std::vector<QueryStructureKind> own_structures() {
  std::vector<QueryStructureKind> kinds;
  const auto add = [&](QueryStructureKind kind) {
    kind.library = "hapton";
    kinds.push_back(std::move(kind));
  };
  add({.name = "brute", .precision = "double", .make = make_plain<Brute<double>>});
  add({.name = "brute", .precision = "float", .make = make_plain<Brute<float>>});
  for (const int division : {8, 16, 32, 64, 128}) {
    add({.name = "grid", .parameter = division, .precision = "double", .make = [division](const TriangleMesh& mesh) {
           return Grid::make(mesh, division);
         }});
  }
  const std::string fdh_note = "planes in float, triangles in double";
  add({.name = "fdh", .parameter = 6, .precision = "double", .note = fdh_note, .make = Fdh<6>::make});
  add({.name = "fdh", .parameter = 14, .precision = "double", .note = fdh_note, .make = Fdh<14>::make});
  add({.name = "fdh", .parameter = 18, .precision = "double", .note = fdh_note, .make = Fdh<18>::make});
  add({.name = "fdh", .parameter = 26, .precision = "double", .note = fdh_note, .make = Fdh<26>::make});
  add({.name = "wide",
       .precision = "double",
       .note = "boxes in float, triangles in double; a segment visits what overlaps its box",
       .make = make_plain<Wide>});
  return kinds;
}

}  // namespace hapton
