#include "core/tool/patch_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace hapton {
namespace {

struct PatchItem {
  PatchItem(const ObjectGeometry& surface, std::uint32_t t, std::uint32_t first_id)
      : corner{surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)},
        normal((corner[1] - corner[0]).cross(corner[2] - corner[0])),
        id(first_id | t) {}

  std::array<Vec3, 3> corner;
  Vec3 normal;  // as long as twice the area
  std::uint32_t id;
  double key = 0.0;  // what it is ordered by

  bool operator<(const PatchItem& other) const { return key != other.key ? key < other.key : id < other.id; }
  Vec3 direction() const { return normal.stableNormalized(); }
  Vec3 centre() const { return (corner[0] + corner[1] + corner[2]) / 3.0; }
};

// The axes of the second moments of a piece of surface (Gottschalk et al., section 4).
struct PatchAxes {
  Mat3 axes = Mat3::Identity();  // columns, from the shortest extent to the longest

  explicit PatchAxes(std::span<const PatchItem> items) {
    const Vec3 origin = items[0].corner[0];
    double area = 0.0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (const PatchItem& item : items) {
      const Vec3 a = item.corner[0] - origin;
      const Vec3 b = item.corner[1] - origin;
      const Vec3 c = item.corner[2] - origin;
      const double weight = item.normal.norm();
      const Vec3 sum = a + b + c;
      area += weight;
      first += weight / 3.0 * sum;
      second += weight / 12.0 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    }
    if (!(area > 0.0)) return;
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(second / area - first * first.transpose() / (area * area));
    const Vec3 shortest = solver.eigenvectors().col(0).normalized();
    const Vec3 longest = shortest.cross(solver.eigenvectors().col(2)).cross(shortest).normalized();
    Mat3 found;
    found << shortest, longest.cross(shortest), longest;
    if (found.allFinite() && (found.transpose() * found - Mat3::Identity()).cwiseAbs().maxCoeff() < 0x1p-30) axes = found;
  }
};

float rounded_up(double x) { return std::nextafter(static_cast<float>(x * (1.0 + 0x1p-40)), std::numeric_limits<float>::infinity()); }

PatchTree::Node box_around(std::span<const PatchItem> items, const Mat3& axes) {
  PatchTree::Node node;
  Mat3 stored;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) stored(k, i) = node.axes[k][i] = static_cast<float>(axes(k, i));
  }
  // Coordinates along the rounded axes, and those of the rounded centre.
  const Mat3 inverse = stored.inverse();
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const PatchItem& item : items) {
    for (const Vec3& p : item.corner) {
      const Vec3 y = inverse * p;
      low = low.cwiseMin(y);
      high = high.cwiseMax(y);
    }
  }
  const Vec3 centre = stored * (0.5 * (low + high));
  for (int i = 0; i < 3; ++i) node.centre[i] = static_cast<float>(centre[i]);
  const Vec3 at = inverse * node.at();
  const double rounding = 0x1p-48 * (1.0 + low.cwiseAbs().maxCoeff() + high.cwiseAbs().maxCoeff());
  for (int i = 0; i < 3; ++i) node.half[i] = rounded_up(std::max(high[i] - at[i], at[i] - low[i]) + rounding);
  return node;
}

// How far the normals of a piece are from parallel: its area less the length of the sum of the normals, both doubled.
struct PatchBend {
  double area = 0.0;
  Vec3 sum = Vec3::Zero();

  void add(const PatchItem& item) {
    area += item.normal.norm();
    sum += item.normal;
  }
  double value() const { return area - sum.norm(); }
  double relative() const { return area > 0.0 ? value() / area : 0.0; }
};

class PatchBuilder {
 public:
  std::vector<PatchItem> items;
  std::vector<PatchTree::Node> nodes;

  void run() {
    if (items.empty()) return;
    nodes.reserve(2 * items.size());
    nodes.resize(1);
    build(0, 0, items.size());
  }

 private:
  void build(std::uint32_t at, std::size_t begin, std::size_t end) {
    const std::span<PatchItem> own(items.data() + begin, end - begin);
    const PatchAxes patch(own);
    PatchTree::Node node = box_around(own, patch.axes);
    if (own.size() == 1) {
      node.link = ~static_cast<std::uint32_t>(begin);
      nodes[at] = node;
      return;
    }
    PatchBend bend;
    for (const PatchItem& item : own) bend.add(item);
    std::size_t half = own.size() / 2;
    if (own.size() <= kLargestBent && bend.relative() > kBent) {
      half = split_by_bend(own, patch.axes);
    } else {
      set_keys(own, Along{patch.axes.col(2), false});
      std::nth_element(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(half), own.end());
    }
    node.link = static_cast<std::uint32_t>(nodes.size());
    nodes[at] = node;
    nodes.resize(nodes.size() + 2);
    build(node.link, begin, begin + half);
    build(node.link + 1, begin + half, end);
  }

  // Orders triangles by their centres, or by their normals.
  struct Along {
    Vec3 axis;
    bool is_by_normal;

    double value(const PatchItem& item) const { return axis.dot(is_by_normal ? item.direction() : item.centre()); }
  };

  static void set_keys(std::span<PatchItem> own, const Along& along) {
    for (PatchItem& item : own) item.key = along.value(item);
  }

  // A corner or a sharp edge is split where that makes the halves flattest, at an eighth of the triangles at least.
  std::size_t split_by_bend(std::span<PatchItem> own, const Mat3& axes) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t best = own.size() / 2;
    Along best_order{axes.col(2), false};
    for (int order = 0; order < 6; ++order) {
      const Along along{axes.col(2 - order % 3), order >= 3};
      set_keys(own, along);
      std::sort(own.begin(), own.end());
      const auto [at, bend] = find_flattest_split(own);
      if (bend < least * (1.0 - 0x1p-10)) {
        least = bend;
        best = at;
        best_order = along;
      }
    }
    set_keys(own, best_order);
    std::sort(own.begin(), own.end());
    return best;
  }

  std::pair<std::size_t, double> find_flattest_split(std::span<const PatchItem> own) {
    bends_.assign(own.size(), 0.0);
    PatchBend before;
    for (std::size_t i = 0; i + 1 < own.size(); ++i) {
      before.add(own[i]);
      bends_[i + 1] = before.value();
    }
    PatchBend after;
    for (std::size_t i = own.size() - 1; i > 0; --i) {
      after.add(own[i]);
      bends_[i] += after.value();
    }
    const std::size_t first = std::max<std::size_t>(1, own.size() / 8);
    const auto least = std::min_element(bends_.begin() + static_cast<std::ptrdiff_t>(first),
                                        bends_.begin() + static_cast<std::ptrdiff_t>(own.size() - first + 1));
    return {static_cast<std::size_t>(least - bends_.begin()), *least};
  }

  static constexpr double kBent = 0.02;
  static constexpr std::size_t kLargestBent = 1024;  // triangles; larger pieces are split in the middle
  std::vector<double> bends_;
};

void add_surface(const ObjectGeometry& surface, std::uint32_t first_id, std::vector<PatchItem>& items) {
  for (std::uint32_t t = 0; t < surface.triangle_count(); ++t) {
    items.emplace_back(surface, t, first_id);
  }
}

}  // namespace

PatchTree::PatchTree(const ObjectGeometry& surface) {
  PatchBuilder builder;
  add_surface(surface, 0, builder.items);
  builder.run();
  nodes_ = std::move(builder.nodes);
  for (const PatchItem& item : builder.items) triangles_.push_back(item.id);
}

PatchTree::PatchTree(const TouchGeometry& scene) {
  PatchBuilder builder;
  const std::uint32_t step = scene.object_bits() & (~scene.object_bits() + 1U);
  for (std::uint32_t o = 0; o < scene.object_count(); ++o) add_surface(scene.object_geometry(o), o * step, builder.items);
  builder.run();
  nodes_ = std::move(builder.nodes);
  for (const PatchItem& item : builder.items) triangles_.push_back(item.id);
}

}  // namespace hapton
