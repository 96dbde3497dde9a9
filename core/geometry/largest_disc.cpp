#include "core/geometry/largest_disc.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace hapton {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kMaxWork = 4e6;  // comparisons of a square with an edge, each about 10 ns

double squared_distance(const Vec2& p, const Segment2& edge) {
  const Vec2 along = edge.second - edge.first;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp((p - edge.first).dot(along) / length, 0.0, 1.0) : 0.0;
  return (edge.first + share * along - p).squaredNorm();
}

// Whether the ray from p in the direction of +y crosses the edge.
bool is_crossed(const Vec2& p, const Segment2& edge) {
  const Vec2& a = edge.first;
  const Vec2& b = edge.second;
  return (a.x() > p.x()) != (b.x() > p.x()) && p.y() < a.y() + (p.x() - a.x()) / (b.x() - a.x()) * (b.y() - a.y());
}

// The edges in columns by their extent along x, to compare a point with the edges near it. Pre: finite, at least one; they outlive this.
class EdgeColumns {
 public:
  EdgeColumns(const std::vector<Segment2>& edges, double low_x, double high_x) : edges_(edges), low_x_(low_x) {
    // An edge is in each column that it reaches, so long edges allow only few columns.
    const auto divide = [&](std::size_t count) {
      count_ = count;
      width_ = (high_x - low_x) / static_cast<double>(count);
    };
    for (divide(std::clamp<std::size_t>(edges.size() / 4, 1, kMostColumns));
         count_ > 1 && count_entries() > kMaxColumnsPerEdge * edges.size();) {
      divide(count_ / 2);
    }
    begins_.assign(count_ + 1, 0);
    for (const Segment2& edge : edges) {
      const auto [first, last] = columns_of(edge);
      for (std::size_t c = first; c <= last; ++c) ++begins_[c + 1];
    }
    for (std::size_t c = 1; c < begins_.size(); ++c) begins_[c] += begins_[c - 1];
    items_.resize(begins_.back());
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto [first, last] = columns_of(edges[e]);
      for (std::size_t c = first; c <= last; ++c) items_[next[c]++] = static_cast<std::uint32_t>(e);
    }
  }

  // Edges in a column, on average.
  double mean_edges_in_column() const { return static_cast<double>(items_.size()) / static_cast<double>(count_); }

  // The distance of p from the nearest edge, negative outside of the polygons. work: grows by the number of edges that were compared.
  double depth_of(const Vec2& p, double& work) const {
    const std::size_t own_column = column_of(p.x());
    double nearest = std::numeric_limits<double>::infinity();
    bool is_inside = false;
    const auto compare = [&](std::size_t column) {
      for (std::size_t n = begins_[column]; n < begins_[column + 1]; ++n) {
        nearest = std::min(nearest, squared_distance(p, edges_[items_[n]]));
        if (column == own_column) is_inside = is_inside != is_crossed(p, edges_[items_[n]]);
      }
      work += static_cast<double>(begins_[column + 1] - begins_[column]);
    };
    compare(own_column);
    for (std::size_t c = own_column; c > 0 && is_nearer(p.x() - begin_of(c), nearest); --c) compare(c - 1);
    for (std::size_t c = own_column + 1; c < count_ && is_nearer(begin_of(c) - p.x(), nearest); ++c) compare(c);
    return is_inside ? std::sqrt(nearest) : -std::sqrt(nearest);
  }

 private:
  static constexpr std::size_t kMostColumns = 4096;
  static constexpr std::size_t kMaxColumnsPerEdge = 3;  // most columns that an edge may be in, on average

  static bool is_nearer(double along, double squared) { return along <= 0.0 || along * along < squared; }
  double begin_of(std::size_t column) const { return low_x_ + width_ * static_cast<double>(column); }
  std::size_t column_of(double x) const {
    return static_cast<std::size_t>(std::min(std::max(0.0, (x - low_x_) / width_), static_cast<double>(count_ - 1)));
  }
  std::pair<std::size_t, std::size_t> columns_of(const Segment2& edge) const {
    const auto [least, most] = std::minmax({edge.first.x(), edge.second.x()});
    return {column_of(least), column_of(most)};
  }

  std::size_t count_entries() const {
    std::size_t count = 0;
    for (const Segment2& edge : edges_) {
      const auto [first, last] = columns_of(edge);
      count += last - first + 1;
    }
    return count;
  }

  const std::vector<Segment2>& edges_;
  double low_x_;
  std::size_t count_ = 1;
  double width_ = 0.0;
  std::vector<std::size_t> begins_;   // where each column begins in items_; then the end of the last
  std::vector<std::uint32_t> items_;  // numbers of edges
};

struct Square {
  Vec2 middle;
  double half = 0.0;   // half of its side
  double depth = 0.0;  // depth_of() its middle
  double max_depth() const { return depth + half * std::sqrt(2.0); }
  bool operator<(const Square& other) const { return max_depth() < other.max_depth(); }
};

using Squares = std::priority_queue<Square>;

// Turns the edges so that they are longest along x.
void align(std::vector<Segment2>& edges) {
  Vec2 mean = Vec2::Zero();
  for (const Segment2& edge : edges) mean += edge.first / static_cast<double>(edges.size());
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (const Segment2& edge : edges) {
    const Vec2 d = edge.first - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const Eigen::Rotation2D<double> turn(-0.5 * std::atan2(2.0 * xy, xx - yy));
  for (Segment2& edge : edges) edge = {Vec2(turn * (edge.first - mean)), Vec2(turn * (edge.second - mean))};
}

// Squares that cover all edges. Their side is the shorter one of the box around the edges, or longer, to limit their number.
Squares cover(const EdgeColumns& edges, const Vec2& low, const Vec2& high, double& work) {
  const double max_count = std::clamp(kMaxWork / edges.mean_edges_in_column(), 1.0, 1024.0);
  const Vec2 size = high - low;
  const double side = std::max(size.minCoeff(), size.maxCoeff() / max_count);
  Squares squares;
  for (double x = low.x() + 0.5 * side; x < high.x() + 0.5 * side; x += side) {
    for (double y = low.y() + 0.5 * side; y < high.y() + 0.5 * side; y += side) {
      squares.push({Vec2(x, y), 0.5 * side, edges.depth_of(Vec2(x, y), work)});
    }
  }
  return squares;
}

}  // namespace

double largest_disc(std::vector<Segment2> edges, double negligible_diameter) {
  constexpr double kAccuracy = 0.01;
  align(edges);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  for (const Segment2& edge : edges) {
    if (!edge.first.allFinite() || !edge.second.allFinite()) return 0.0;
    low = low.cwiseMin(edge.first).cwiseMin(edge.second);
    high = high.cwiseMax(edge.first).cwiseMax(edge.second);
  }
  const double narrowest = edges.empty() ? 0.0 : (high - low).minCoeff();
  // The polygons are no wider than `negligible_diameter`, or a sliver within rounding.
  if (!(narrowest > std::max(negligible_diameter, 0x1p-40 * (high - low).maxCoeff()))) return narrowest;
  const EdgeColumns columns(edges, low.x(), high.x());
  double work = 0.0;
  Squares squares = cover(columns, low, high, work);
  double best = 0.0;
  while (work < kMaxWork && squares.top().max_depth() > std::max((1.0 + kAccuracy) * best, 0.5 * negligible_diameter)) {
    const Square square = squares.top();
    squares.pop();
    best = std::max(best, square.depth);
    const double half = 0.5 * square.half;
    for (const double x : {-half, half}) {
      for (const double y : {-half, half}) {
        const Vec2 middle = square.middle + Vec2(x, y);
        squares.push({middle, half, columns.depth_of(middle, work)});
      }
    }
  }
  // No disc is wider than the shorter side of the box around the edges.
  return std::min(2.0 * squares.top().max_depth(), narrowest);
}

}  // namespace hapton
