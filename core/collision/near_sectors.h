#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/collision/box.h"

namespace hapton {

// Finds, among the sectors of the triangles at a vertex, the pairs that may come near each other as seen from the vertex. A sweep along one
// axis over the boxes of their arcs on the unit sphere (sweep and prune) leaves few pairs; the plane of one sector separates most of these.
// RT: set-up only.
class NearSectors {
 public:
  using Edges = std::array<Vec3, 2>;  // from the vertex, of any length

  // `angle`: how near two sectors have to come to form a pair, in rad; far below 1.
  NearSectors(std::span<const Edges> sectors, double angle) : least_sine_(2.0 * angle) {
    items_.reserve(sectors.size());
    for (std::uint32_t i = 0; i < sectors.size(); ++i) items_.push_back(make_item(sectors[i], angle, i));
    const int axis = choose_axis();
    std::sort(items_.begin(), items_.end(), [axis](const Item& a, const Item& b) { return a.box.low[axis] < b.box.low[axis]; });
    axis_ = axis;
  }

  // Calls visit(i, j) once for each pair of sectors that may be `angle` or less apart, and for some others. All other pairs are farther.
  template <class Visit>
  void visit_pairs(Visit&& visit) const {
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const Item& a = items_[i];
      for (std::size_t j = i + 1; j < items_.size() && items_[j].box.low[axis_] <= a.box.high[axis_]; ++j) {
        const Item& b = items_[j];
        if (a.box.overlaps(b.box) && !is_beside(a, b) && !is_beside(b, a)) visit(a.sector, b.sector);
      }
    }
  }

 private:
  struct Item {
    Box box;                       // of the arc, grown for `angle` and rounding
    Edges edge;                    // unit vectors; zero for an edge without length
    Vec3 normal;                   // not of unit length
    double min_far_product = 0.0;  // a unit vector whose product with `normal` is larger is certainly far from the plane
    std::uint32_t sector = 0;
  };

  // Whether both edges of b, and so its whole sector, are on one side of the plane of a.
  static bool is_beside(const Item& a, const Item& b) {
    const double first = a.normal.dot(b.edge[0]);
    const double last = a.normal.dot(b.edge[1]);
    return std::min(first, last) > a.min_far_product || std::max(first, last) < -a.min_far_product;
  }

  Item make_item(const Edges& sector, double angle, std::uint32_t i) const {
    constexpr double kRounding = 0x1p-48;  // above that of unit vectors and their cross products
    Item item;
    item.sector = i;
    for (std::size_t k = 0; k < 2; ++k) item.edge[k] = sector[k].stableNormalized();
    item.normal = item.edge[0].cross(item.edge[1]);
    item.min_far_product = least_sine_ * item.normal.norm() + kRounding;
    const bool has_length = !item.edge[0].isZero(0.0) && !item.edge[1].isZero(0.0);
    // The arc is nowhere farther from its chord than in its middle.
    const double bulge = has_length ? 1.0 - 0.5 * (item.edge[0] + item.edge[1]).norm() : 2.0;
    item.box = Box::around(item.edge[0], item.edge[1]).inflated(bulge + angle + kRounding);
    return item;
  }

  // The axis along which the arcs overlap least.
  int choose_axis() const {
    Box all;
    Vec3 lengths = Vec3::Zero();
    for (const Item& item : items_) {
      all.grow(item.box);
      lengths += item.box.high - item.box.low;
    }
    const Vec3 size = all.high - all.low;
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
      if (lengths[k] * size[axis] < lengths[axis] * size[k]) axis = k;
    }
    return axis;
  }

  double least_sine_;
  int axis_ = 0;
  std::vector<Item> items_;
};

}  // namespace hapton
