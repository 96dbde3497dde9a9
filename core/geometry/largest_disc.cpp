#include "core/geometry/largest_disc.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace hapton {
namespace {

using Vec2 = Eigen::Vector2d;

double squared_distance(const Vec2& p, const Segment2& edge) {
  const Vec2 along = edge.second - edge.first;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp((p - edge.first).dot(along) / length, 0.0, 1.0) : 0.0;
  return (edge.first + share * along - p).squaredNorm();
}

// Whether the ray from p in the direction of x crosses it.
bool is_crossed(const Vec2& p, const Segment2& edge) {
  const auto& [a, b] = edge;
  if ((a.y() > p.y()) == (b.y() > p.y())) return false;
  return p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

// From the edges; negative outside.
double depth_of(const Vec2& p, const std::vector<Segment2>& edges) {
  double nearest = std::numeric_limits<double>::infinity();
  bool is_inside = false;
  for (const Segment2& edge : edges) {
    nearest = std::min(nearest, squared_distance(p, edge));
    is_inside = is_inside != is_crossed(p, edge);
  }
  return is_inside ? std::sqrt(nearest) : -std::sqrt(nearest);
}

struct Square {
  Vec2 middle;
  double half = 0.0;   // of its side
  double depth = 0.0;  // of its middle
  double most() const { return depth + half * std::sqrt(2.0); }
  bool operator<(const Square& other) const { return most() < other.most(); }
};

using Squares = std::priority_queue<Square>;

// Turned so that they are longest along x.
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

// They cover all edges, and are no wider than these are high.
Squares cover(const std::vector<Segment2>& edges, const Vec2& low, const Vec2& high) {
  constexpr double kMost = 1024.0;
  const Vec2 size = high - low;
  const double side = std::max(size.minCoeff(), size.maxCoeff() / kMost);
  Squares squares;
  for (double x = low.x() + 0.5 * side; x < high.x() + 0.5 * side; x += side) {
    for (double y = low.y() + 0.5 * side; y < high.y() + 0.5 * side; y += side) {
      squares.push({Vec2(x, y), 0.5 * side, depth_of(Vec2(x, y), edges)});
    }
  }
  return squares;
}

}  // namespace

double largest_disc(std::vector<Segment2> edges, double enough) {
  constexpr double kAccuracy = 0.01;
  constexpr double kMaxWork = 4e6;  // edges times squares, each about 10 ns
  align(edges);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  for (const Segment2& edge : edges) {
    if (!edge.first.allFinite() || !edge.second.allFinite()) return 0.0;
    low = low.cwiseMin(edge.first).cwiseMin(edge.second);
    high = high.cwiseMax(edge.first).cwiseMax(edge.second);
  }
  const double narrowest = edges.empty() ? 0.0 : (high - low).minCoeff();
  // Not a sliver of rounding.
  if (!(narrowest > std::max(enough, 0x1p-40 * (high - low).maxCoeff()))) return narrowest;
  Squares squares = cover(edges, low, high);
  double best = 0.0;
  const double work_of_four = 4.0 * static_cast<double>(edges.size());
  for (double work = 0.0; work < kMaxWork && squares.top().most() > std::max((1.0 + kAccuracy) * best, 0.5 * enough);
       work += work_of_four) {
    const Square square = squares.top();
    squares.pop();
    best = std::max(best, square.depth);
    const double half = 0.5 * square.half;
    for (const double x : {-half, half}) {
      for (const double y : {-half, half}) {
        const Vec2 middle = square.middle + Vec2(x, y);
        squares.push({middle, half, depth_of(middle, edges)});
      }
    }
  }
  // No disc is wider than the narrower side of what they span.
  return std::min(2.0 * squares.top().most(), narrowest);
}

}  // namespace hapton
