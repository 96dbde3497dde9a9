#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/point_triangle.h"

namespace hapton {

// A triangle with everything precomputed that does not depend on the query: a separation takes no square root and no division over the
// face, one of each over an edge. Same contract as separation_from_triangle. RT: yes.
class ContactTriangle {
 public:
  ContactTriangle() = default;
  ContactTriangle(const Vec3& a, const Vec3& b, const Vec3& c) : corner_{a, b, c}, edge_{b - a, c - b, a - c} {
    const Vec3 normal = accurate_cross(edge_[0], -edge_[2]);
    const double length = normal.norm();
    normal_ = length > 0.0 ? Vec3(normal / length) : Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      inward_[k] = normal_.cross(edge_[k]);
      const double squared = edge_[k].squaredNorm();
      length_[k] = std::sqrt(squared);
      inverse_squared_[k] = squared > 0.0 ? 1.0 / squared : 0.0;
    }
  }

  const Vec3& corner(int k) const { return corner_[k]; }
  const Vec3& edge(int k) const { return edge_[k]; }  // from corner k to the next
  double length(int k) const { return length_[k]; }   // of edge k
  const Vec3& normal() const { return normal_; }      // unit, by the vertex order; zero without area

  // How far inside edge k a point of the plane lies, times the edge's length: negative outside.
  double inside(int k, const Vec3& p) const { return inward_[k].dot(p - corner_[k]); }
  // Position of a point along edge k: 0 at corner k, 1 at the next.
  double along(int k, const Vec3& p) const { return edge_[k].dot(p - corner_[k]) * inverse_squared_[k]; }

  // The edge closest to a point of the face, and the distance of the point from the edge.
  struct Boundary {
    int edge = 0;
    double distance = 0.0;
  };
  Boundary boundary(const Vec3& on_face) const {
    Boundary nearest{0, std::numeric_limits<double>::infinity()};
    for (int k = 0; k < 3; ++k) {
      const double distance = std::fabs(inward_[k].dot(on_face - corner_[k])) * std::sqrt(inverse_squared_[k]);
      if (distance < nearest.distance) nearest = {k, distance};
    }
    return nearest;
  }

  bool is_near_boundary(const Vec3& on_face, double distance) const {
    bool is_any_near = false;
    for (int k = 0; k < 3; ++k) {
      const double off = inward_[k].dot(on_face - corner_[k]);
      is_any_near |= off * off * inverse_squared_[k] <= distance * distance;
    }
    return is_any_near;
  }

  Separation separation(const Vec3& p) const {
    const Vec3 from[3] = {p - corner_[0], p - corner_[1], p - corner_[2]};
    const bool inside[3] = {inward_[0].dot(from[0]) > 0.0, inward_[1].dot(from[1]) > 0.0, inward_[2].dot(from[2]) > 0.0};
    if (inside[0] && inside[1] && inside[2]) {
      const double height = normal_.dot(from[0]);
      const double distance = std::fabs(height);
      const Vec3 unit = height < 0.0 ? Vec3(-normal_) : normal_;
      return {distance, unit, p - distance * unit, Feature::face};
    }
    double best_squared = std::numeric_limits<double>::infinity();
    Vec3 best_off = Vec3::Zero();
    int best_edge = 0;
    double best_t = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (inside[k]) continue;
      const double t = std::min(1.0, std::max(0.0, from[k].dot(edge_[k]) * inverse_squared_[k]));
      const Vec3 off = from[k] - t * edge_[k];
      const double squared = off.squaredNorm();
      if (!(squared < best_squared)) continue;
      best_squared = squared;
      best_off = off;
      best_edge = k;
      best_t = t;
    }
    Separation result;
    result.nearest = corner_[best_edge] + best_t * edge_[best_edge];
    result.feature = best_t > 0.0 && best_t < 1.0 ? Feature::edge : Feature::vertex;
    if (result.feature == Feature::edge && best_squared * inverse_squared_[best_edge] < detail::kShortSquaredShare) {
      best_off = detail::perpendicular_to(edge_[best_edge], inverse_squared_[best_edge], best_off);
      best_squared = best_off.squaredNorm();
    }
    result.distance = std::sqrt(best_squared);
    if (result.distance > 0.0) {
      result.normal = best_off / result.distance;
    } else if (!normal_.isZero(0.0)) {
      result.normal = normal_;
    } else {
      result.normal = edge_[best_edge].squaredNorm() > 0.0 ? edge_[best_edge].unitOrthogonal() : Vec3::UnitX();
    }
    return result;
  }

 private:
  Vec3 corner_[3];
  Vec3 edge_[3];    // from corner k to the next
  Vec3 normal_;     // unit; zero without area
  Vec3 inward_[3];  // in the plane, perpendicular to edge k, towards the inside
  double inverse_squared_[3];
  double length_[3];
};

}  // namespace hapton
