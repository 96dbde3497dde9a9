#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "core/force/force_method.h"

namespace hapton::made {

// The rule of method sweep over all triangles of the scene, without a grid and without the product's collision code: signed volumes in long
// double (E. Segura and F. Feito 2001) instead of a plane in double and a crossings test. Its results equal the product's up to rounding.
class BruteForceSweep {
 public:
  BruteForceSweep(const TouchScene& scene, double offset_m) : offset_m_(offset_m) {
    for (const TouchObject& object : scene.objects) {
      for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t) {
        Face face{wide(object.mesh->corner(t, 0)), wide(object.mesh->corner(t, 1)), wide(object.mesh->corner(t, 2)), Wide::Zero(),
                  object.material.stiffness_n_per_m};
        if (!has_plane(face)) continue;
        face.normal = (face.b - face.a).cross(face.c - face.a).normalized();
        faces_.push_back(face);
      }
    }
  }

  void reset(const Vec3& p) { line_start_ = p; }

  MethodOutput step(const Vec3& p) {
    std::vector<std::tuple<long double, long double, std::size_t, Hit>> found;
    for (std::size_t t = 0; t < faces_.size(); ++t) {
      if (const auto hit = find_hit(faces_[t], wide(line_start_), wide(p))) found.emplace_back(hit->t, -hit->depth, t, *hit);
    }
    collisions = found.size();
    MethodOutput output;
    output.p_SP = p;
    line_start_ = p;
    if (!found.empty()) {
      const auto& [t, depth, id, hit] = *std::min_element(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return std::tie(std::get<0>(a), std::get<1>(a), std::get<2>(a)) < std::tie(std::get<0>(b), std::get<1>(b), std::get<2>(b));
      });
      line_start_ = (hit.point + offset_m_ * hit.normal).template cast<double>();
      output.force_n = (faces_[id].stiffness_n_per_m * hit.depth * hit.normal).template cast<double>();
      output.p_SP = hit.point.template cast<double>();
      output.contact = output.force_n != Vec3::Zero();
    }
    return output;
  }

  std::size_t collisions = 0;  // in the last step

 private:
  using Wide = Eigen::Matrix<long double, 3, 1>;
  struct Face {
    Wide a, b, c;
    Wide normal;
    long double stiffness_n_per_m;
  };
  struct Hit {
    long double t;
    long double depth;
    Wide point;
    Wide normal;
  };

  static Wide wide(const Vec3& v) { return v.cast<long double>(); }
  // Of the parallelepiped, signed.
  static long double volume(const Wide& u, const Wide& v, const Wide& w) { return u.dot(v.cross(w)); }

  // A triangle thinner than the rounding of its corners in double has no plane.
  static bool has_plane(const Face& face) {
    const Wide ab = face.b - face.a;
    const Wide ac = face.c - face.a;
    const long double size = std::max(ab.cwiseAbs().maxCoeff(), ac.cwiseAbs().maxCoeff());
    return size > 0 && (ab / size).cross(ac / size).norm() > 4 * static_cast<long double>(std::numeric_limits<double>::epsilon());
  }

  // A point on the plane counts as above it: if two consecutive lines meet on the plane and cross it there, exactly one of them collides.
  static std::optional<Hit> find_hit(const Face& face, const Wide& from, const Wide& to) {
    const long double height_from = face.normal.dot(from - face.a);
    const long double height_to = face.normal.dot(to - face.a);
    if ((height_from >= 0) == (height_to >= 0)) return std::nullopt;
    const Wide line = to - from;
    const long double ab = volume(line, face.a - from, face.b - from);
    const long double bc = volume(line, face.b - from, face.c - from);
    const long double ca = volume(line, face.c - from, face.a - from);
    // A hit beside an edge, within the rounding of double, counts as in the triangle.
    const long double size = (face.a - from).norm() + (face.b - from).norm() + (face.c - from).norm();
    const long double tolerance = 8 * static_cast<long double>(std::numeric_limits<double>::epsilon()) * size * size * line.norm();
    const bool is_inside =
        (ab >= -tolerance && bc >= -tolerance && ca >= -tolerance) || (ab <= tolerance && bc <= tolerance && ca <= tolerance);
    if (!is_inside) return std::nullopt;
    const long double t = height_from / (height_from - height_to);
    const Wide outward = height_from >= 0 ? face.normal : Wide(-face.normal);
    return Hit{t, std::abs(height_to), from + t * line, outward};
  }

  double offset_m_;
  std::vector<Face> faces_;
  Vec3 line_start_ = Vec3::Zero();  // of the next step: the last device point, or a point above the last collision
};

}  // namespace hapton::made
