#include "core/tool/obb_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "core/geometry/triangle_distance.h"
#include "core/math/rounded_to_float.h"

namespace hapton {
namespace {

struct TreeTriangle {
  TreeTriangle(const ObjectGeometry& surface, std::uint32_t t, std::uint32_t first_id)
      : corner{surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)},
        normal((corner[1] - corner[0]).cross(corner[2] - corner[0])),
        centre((corner[0] + corner[1] + corner[2]) / 3.0),
        area(normal.norm()),
        id(first_id | t) {
    for (const Vec3& p : corner) second_moments += area / 12.0 * (p - centre) * (p - centre).transpose();
  }

  std::array<Vec3, 3> corner;
  Vec3 normal;  // its length is twice the area
  Vec3 centre;
  Mat3 second_moments = Mat3::Zero();  // second moments about the centre, doubled
  double area;                         // doubled
  std::uint32_t id;

  Vec3 direction() const { return normal.stableNormalized(); }
  Vec3 longest_edge() const {
    Vec3 longest = corner[1] - corner[0];
    for (const Vec3& edge : {Vec3(corner[2] - corner[1]), Vec3(corner[0] - corner[2])}) {
      if (edge.squaredNorm() > longest.squaredNorm()) longest = edge;
    }
    return longest;
  }
};

// A piece of a surface: the numbers of its triangles.
struct SurfacePiece {
  std::span<const TreeTriangle> items;  // all triangles of the surface
  std::span<std::uint32_t> numbers;

  std::size_t size() const { return numbers.size(); }
  const TreeTriangle& operator[](std::size_t i) const { return items[numbers[i]]; }
};

// Sort key of a triangle.
struct SortKey {
  double key;
  std::uint32_t id;
  std::uint32_t number;  // number of the triangle

  bool operator<(const SortKey& other) const { return key != other.key ? key < other.key : id < other.id; }
};

// The axes of the second moments of a piece of surface (Gottschalk et al., section 4). For one triangle: its normal and longest edge.
struct PieceAxes {
  Mat3 axes = Mat3::Identity();  // columns, from the shortest extent to the longest

  explicit PieceAxes(const SurfacePiece& piece) {
    if (piece.size() == 1) {
      set(piece[0].direction(), piece[0].longest_edge());
      return;
    }
    const Vec3 origin = piece[0].centre;
    double area = 0.0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const TreeTriangle& item = piece[i];
      const Vec3 from = item.centre - origin;
      const Vec3 weighted = item.area * from;
      area += item.area;
      first += weighted;
      second += weighted * from.transpose() + item.second_moments;
    }
    if (!(area > 0.0)) return;
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(second / area - first * first.transpose() / (area * area));
    set(solver.eigenvectors().col(0).normalized(), solver.eigenvectors().col(2));
  }

 private:
  void set(const Vec3& shortest, const Vec3& about_longest) {
    const Vec3 longest = shortest.cross(about_longest).cross(shortest).normalized();
    Mat3 found;
    found << shortest, longest.cross(shortest), longest;
    if (found.allFinite() && (found.transpose() * found - Mat3::Identity()).cwiseAbs().maxCoeff() < 0x1p-30) axes = found;
  }
};

float to_float(double x) { return static_cast<float>(rounded_to_float(x)); }
float rounded_up(double x) { return std::nextafter(static_cast<float>(x * (1.0 + 0x1p-40)), std::numeric_limits<float>::infinity()); }

ObbTree::Node box_around(const SurfacePiece& piece, const Mat3& axes) {
  ObbTree::Node node;
  Mat3 stored;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) stored(k, i) = node.axes[k][i] = to_float(axes(k, i));
  }
  // Extents along the rounded axes and about the rounded centre, so that the box as stored contains the corners.
  const Mat3 inverse = stored.inverse();
  const auto lanes_of_column = [&](int i) { return Lanes4{inverse(0, i), inverse(1, i), inverse(2, i), inverse(2, i)}; };
  const Lanes4 columns[3] = {lanes_of_column(0), lanes_of_column(1), lanes_of_column(2)};
  Lanes4 least = Lanes4{} + std::numeric_limits<double>::infinity();
  Lanes4 most = -least;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    for (const Vec3& p : piece[i].corner) {
      const Lanes4 y = p.x() * columns[0] + p.y() * columns[1] + p.z() * columns[2];
      least = detail::lane_min(y, least);
      most = detail::lane_max(y, most);
    }
  }
  const Vec3 low(least[0], least[1], least[2]);
  const Vec3 high(most[0], most[1], most[2]);
  const Vec3 centre = stored * (0.5 * (low + high));
  for (int i = 0; i < 3; ++i) node.centre[i] = to_float(centre[i]);
  const Vec3 at = inverse * node.at();
  const double rounding = 0x1p-48 * (1.0 + low.cwiseAbs().maxCoeff() + high.cwiseAbs().maxCoeff());
  for (int i = 0; i < 3; ++i) node.half[i] = rounded_up(std::max(high[i] - at[i], at[i] - low[i]) + rounding);
  return node;
}

// How far the normals of a piece are from parallel: its area less the length of the sum of the normals, both doubled.
struct PieceBend {
  double area = 0.0;
  Vec3 sum = Vec3::Zero();

  void add(const TreeTriangle& item) {
    area += item.area;
    sum += item.normal;
  }
  double value() const { return area - sum.norm(); }
  double relative() const { return area > 0.0 ? value() / area : 0.0; }
};

class TreeBuilder {
 public:
  std::vector<TreeTriangle> items;
  std::vector<std::uint32_t> numbers;  // numbers of the items, leaf by leaf
  LargeVector<ObbTree::Node> nodes;

  void run() {
    if (items.empty()) return;
    nodes.reserve(2 * items.size());
    keys_.resize(items.size());
    numbers.resize(items.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    nodes.resize(1);
    build(0, 0, items.size());
  }

 private:
  void build(std::uint32_t at, std::size_t begin, std::size_t end) {
    const SurfacePiece own{items, std::span(numbers).subspan(begin, end - begin)};
    const PieceAxes along(own);
    ObbTree::Node node = box_around(own, along.axes);
    if (own.size() == 1) {
      node.link = ~static_cast<std::uint32_t>(begin);
      nodes[at] = node;
      return;
    }
    PieceBend bend;
    for (std::size_t i = 0; i < own.size(); ++i) bend.add(own[i]);
    std::size_t half = own.size() / 2;
    if (own.size() <= kLargestBent && bend.relative() > kMinBend) {
      half = split_by_bend(own, along.axes);
    } else {
      const std::span<SortKey> keys = keys_of(own, SortAxis{along.axes.col(2), false});
      std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(half), keys.end());
      reorder(own, keys);
    }
    node.link = static_cast<std::uint32_t>(nodes.size());
    nodes[at] = node;
    nodes.resize(nodes.size() + 2);
    build(node.link, begin, begin + half);
    build(node.link + 1, begin + half, end);
  }

  // Orders triangles along an axis by their centres, or by their normals.
  struct SortAxis {
    Vec3 axis;
    bool is_by_normal;

    double value(const TreeTriangle& item) const { return axis.dot(is_by_normal ? item.direction() : item.centre); }
  };

  // The keys of a piece's triangles, in the order of the piece.
  std::span<SortKey> keys_of(const SurfacePiece& own, const SortAxis& along) {
    for (std::size_t i = 0; i < own.size(); ++i) keys_[i] = {along.value(own[i]), own[i].id, own.numbers[i]};
    return std::span(keys_).first(own.size());
  }
  static void reorder(const SurfacePiece& own, std::span<const SortKey> keys) {
    for (std::size_t i = 0; i < own.size(); ++i) own.numbers[i] = keys[i].number;
  }

  // Orders a piece with a corner or a sharp edge so that its halves are as flat as possible, each with at least an eighth of the triangles.
  // Returns the size of the first half.
  std::size_t split_by_bend(const SurfacePiece& own, const Mat3& axes) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t best = own.size() / 2;
    for (int order = 0; order < 6; ++order) {
      const std::span<SortKey> keys = keys_of(own, {axes.col(2 - order % 3), order >= 3});
      std::sort(keys.begin(), keys.end());
      const auto [at, bend] = find_flattest_split(keys);
      const bool is_flatter = bend < least * (1.0 - 0x1p-10);
      if (is_flatter) {
        least = bend;
        best = at;
      }
      if (is_flatter || order == 0) best_keys_.assign(keys.begin(), keys.end());
    }
    reorder(own, best_keys_);
    return best;
  }

  std::pair<std::size_t, double> find_flattest_split(std::span<const SortKey> keys) {
    bends_.assign(keys.size(), 0.0);
    PieceBend before;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
      before.add(items[keys[i].number]);
      bends_[i + 1] = before.value();
    }
    PieceBend after;
    for (std::size_t i = keys.size() - 1; i > 0; --i) {
      after.add(items[keys[i].number]);
      bends_[i] += after.value();
    }
    const std::size_t first = std::max<std::size_t>(1, keys.size() / 8);
    const auto least = std::min_element(bends_.begin() + static_cast<std::ptrdiff_t>(first),
                                        bends_.begin() + static_cast<std::ptrdiff_t>(keys.size() - first + 1));
    return {static_cast<std::size_t>(least - bends_.begin()), *least};
  }

  static constexpr double kMinBend = 0.02;           // PieceBend::relative() above which split_by_bend is used
  static constexpr std::size_t kLargestBent = 1024;  // triangles; larger pieces are split in the middle
  std::vector<double> bends_;
  std::vector<SortKey> keys_;
  std::vector<SortKey> best_keys_;
};

// Puts the trees of objects under one root.
class TreeJoiner {
 public:
  LargeVector<ObbTree::Node> nodes;
  std::vector<std::uint32_t> triangles;

  TreeJoiner(std::span<const ObbTree* const> trees, const TouchGeometry& scene) {
    const std::uint32_t step = object_step(scene);
    std::size_t node_count = 0;
    for (std::uint32_t o = 0; o < trees.size(); ++o) {
      if (trees[o]->nodes().empty()) continue;
      objects_.push_back({trees[o], o * step, scene.object_geometry(o).bounds()});
      node_count += trees[o]->nodes().size() + 1;
    }
    if (objects_.empty()) return;
    nodes.reserve(node_count);
    nodes.resize(1);
    build(0, objects_);
  }

  // Difference between the triangle numbers of one object and the next.
  static std::uint32_t object_step(const TouchGeometry& scene) { return scene.object_bits() & (~scene.object_bits() + 1U); }

 private:
  struct Object {
    const ObbTree* tree;
    std::uint32_t first_id;
    Box bounds;
  };

  void build(std::uint32_t at, std::span<Object> objects) {
    if (objects.size() == 1) {
      copy_tree(at, objects[0]);
      return;
    }
    Box bounds;
    for (const Object& object : objects) bounds.grow(object.bounds);
    ObbTree::Node node = box_along(bounds);
    int longest = 0;
    (bounds.high - bounds.low).maxCoeff(&longest);
    const std::size_t half = objects.size() / 2;
    std::nth_element(objects.begin(), objects.begin() + static_cast<std::ptrdiff_t>(half), objects.end(),
                     [longest](const Object& a, const Object& b) {
                       const double centre_a = a.bounds.centre()[longest];
                       const double centre_b = b.bounds.centre()[longest];
                       return centre_a != centre_b ? centre_a < centre_b : a.first_id < b.first_id;
                     });
    node.link = static_cast<std::uint32_t>(nodes.size());
    nodes[at] = node;
    nodes.resize(nodes.size() + 2);
    build(node.link, objects.first(half));
    build(node.link + 1, objects.subspan(half));
  }

  // A box along the coordinate axes. Its own axes are these in the order of its extents, the shortest first.
  static ObbTree::Node box_along(const Box& bounds) {
    const Vec3 size = bounds.high - bounds.low;
    std::array<int, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return size[a] < size[b]; });
    ObbTree::Node node = {};
    for (int k = 0; k < 3; ++k) node.centre[k] = to_float(bounds.centre()[k]);
    for (int i = 0; i < 3; ++i) {
      const int k = order[i];
      node.axes[k][i] = 1.0F;
      node.half[i] = rounded_up(std::max(bounds.high[k] - node.at()[k], node.at()[k] - bounds.low[k]));
    }
    return node;
  }

  // Copies the tree of an object: its root to node `at`, all other nodes to the end.
  void copy_tree(std::uint32_t at, const Object& object) {
    const auto shift = static_cast<std::uint32_t>(nodes.size() - 1);
    const auto first_leaf = static_cast<std::uint32_t>(triangles.size());
    const auto placed = [&](const ObbTree::Node& node) {
      ObbTree::Node other = node;
      other.link = node.is_leaf() ? ~(~node.link + first_leaf) : node.link + shift;
      return other;
    };
    const std::span<const ObbTree::Node> own = object.tree->nodes();
    nodes[at] = placed(own[0]);
    for (const ObbTree::Node& node : own.subspan(1)) nodes.push_back(placed(node));
    for (const std::uint32_t id : object.tree->triangles()) triangles.push_back(object.first_id | id);
  }

  std::vector<Object> objects_;
};

void add_surface(const ObjectGeometry& surface, std::uint32_t first_id, std::vector<TreeTriangle>& items) {
  for (std::uint32_t t = 0; t < surface.triangle_count(); ++t) {
    items.emplace_back(surface, t, first_id);
  }
}

}  // namespace

ObbTree::ObbTree(const ObjectGeometry& surface) {
  TreeBuilder builder;
  add_surface(surface, 0, builder.items);
  builder.run();
  nodes_ = std::move(builder.nodes);
  for (const std::uint32_t number : builder.numbers) triangles_.push_back(builder.items[number].id);
}

ObbTree::ObbTree(const TouchGeometry& scene) {
  TreeBuilder builder;
  const std::uint32_t step = TreeJoiner::object_step(scene);
  for (std::uint32_t o = 0; o < scene.object_count(); ++o) add_surface(scene.object_geometry(o), o * step, builder.items);
  builder.run();
  nodes_ = std::move(builder.nodes);
  for (const std::uint32_t number : builder.numbers) triangles_.push_back(builder.items[number].id);
}

ObbTree::ObbTree(std::span<const ObbTree* const> objects, const TouchGeometry& scene) {
  TreeJoiner joiner(objects, scene);
  nodes_ = std::move(joiner.nodes);
  triangles_ = std::move(joiner.triangles);
}

ObbTree ObbTree::with_origin_at(const Vec3& p) const {
  ObbTree moved(*this);
  for (Node& node : moved.nodes_) {
    const Vec3 centre = node.at() - p;
    for (int i = 0; i < 3; ++i) node.centre[i] = to_float(centre[i]);
    // The axes are orthonormal within 2^-20.
    const double rounding = (node.at() - centre).norm() * (1.0 + 0x1p-16) + 0x1p-48 * (1.0 + centre.cwiseAbs().maxCoeff());
    for (float& half : node.half) half = rounded_up(half + rounding);
  }
  return moved;
}

}  // namespace hapton
