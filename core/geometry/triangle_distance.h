#pragma once

#include <array>

#include "core/math/types.h"

namespace hapton {

// Four doubles as one value, for which the compiler uses vector instructions where the CPU that it compiles for has them.
using Lanes4 = double __attribute__((vector_size(32)));

namespace detail {

inline double lane_min(double a, double b) { return a < b ? a : b; }
inline double lane_max(double a, double b) { return a > b ? a : b; }
inline Lanes4 lane_min(const Lanes4& a, const Lanes4& b) { return a < b ? a : b; }
inline Lanes4 lane_max(const Lanes4& a, const Lanes4& b) { return a > b ? a : b; }

// A vector in space whose components are numbers (T = double) or four numbers each (T = Lanes4).
template <class T>
struct Of3 {
  T x, y, z;
  friend Of3 operator-(const Of3& a, const Of3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Of3 operator+(const Of3& a, const Of3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Of3 operator*(const T& s, const Of3& a) { return {s * a.x, s * a.y, s * a.z}; }
  T dot(const Of3& b) const { return x * b.x + y * b.y + z * b.z; }
};

template <class T>
inline T zero_lanes() {
  return T{};
}
template <class T>
inline T fill(double value) {
  return T{} + value;
}
// a / b where b > 0, otherwise 0.
template <class T>
inline T divide_or_zero(const T& a, const T& b) {
  const auto positive = b > zero_lanes<T>();
  const T safe = positive ? b : fill<T>(1.0);
  return positive ? a / safe : zero_lanes<T>();
}

// The squared distance from a point to the segment a, a + edge; ap = point - a.
template <class T>
inline T segment_distance_squared(const Of3<T>& ap, const Of3<T>& edge) {
  const T zero = zero_lanes<T>();
  const T t = lane_min(fill<T>(1.0), lane_max(zero, divide_or_zero<T>(ap.dot(edge), edge.dot(edge))));
  const Of3<T> off = ap - t * edge;
  return off.dot(off);
}

}  // namespace detail

// The squared distance from p to triangle abc, for one triangle (T = double) or four at once (T = Lanes4), with the same result to the bit.
// It is measured to a computed point of the triangle, so that it is too small only by the rounding of that point; needles and triangles
// without area are allowed (their edges decide). RT: yes. Source: the face by barycentric coordinates (Ericson, Real-Time Collision
// Detection, 5.1.5), otherwise the closest edge.
template <class T>
inline T triangle_distance_squared(const detail::Of3<T>& p, const detail::Of3<T>& a, const detail::Of3<T>& b, const detail::Of3<T>& c) {
  using detail::Of3;
  const T zero = detail::zero_lanes<T>();
  const Of3<T> ab = b - a;
  const Of3<T> ac = c - a;
  const Of3<T> ap = p - a;
  const T d00 = ab.dot(ab);
  const T d01 = ab.dot(ac);
  const T d11 = ac.dot(ac);
  const T d20 = ap.dot(ab);
  const T d21 = ap.dot(ac);
  const T area = d00 * d11 - d01 * d01;
  const T v = detail::divide_or_zero<T>(d11 * d20 - d01 * d21, area);
  const T w = detail::divide_or_zero<T>(d00 * d21 - d01 * d20, area);
  const T u = 1.0 - v - w;
  const Of3<T> off = ap - (v * ab + w * ac);
  const T plane = off.dot(off);
  const T edges =
      detail::lane_min(detail::segment_distance_squared<T>(ap, ab),
                       detail::lane_min(detail::segment_distance_squared<T>(ap, ac), detail::segment_distance_squared<T>(p - b, c - b)));
  const T worst = detail::lane_min(u, detail::lane_min(v, w));
  return worst > zero ? detail::lane_min(plane, edges) : edges;
}

inline detail::Of3<double> of3(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

inline double triangle_distance_squared(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  return triangle_distance_squared<double>(of3(p), of3(a), of3(b), of3(c));
}

namespace detail {

// The squared distance between segments p + s d, s in [0, 1], and a + t e, t in [0, 1] (Ericson 5.1.9). Either may have length zero.
template <class T>
inline T segment_segment_distance_squared(const Of3<T>& p, const Of3<T>& d, const Of3<T>& a, const Of3<T>& e) {
  const T zero = zero_lanes<T>();
  const T one = fill<T>(1.0);
  const Of3<T> r = p - a;
  const T dd = d.dot(d);
  const T ee = e.dot(e);
  const T de = d.dot(e);
  const T dr = d.dot(r);
  const T er = e.dot(r);
  const T denominator = dd * ee - de * de;
  T s = lane_min(one, lane_max(zero, divide_or_zero<T>(de * er - dr * ee, denominator)));
  const T t = lane_min(one, lane_max(zero, divide_or_zero<T>(de * s + er, ee)));
  s = lane_min(one, lane_max(zero, divide_or_zero<T>(de * t - dr, dd)));
  const Of3<T> off = (r + s * d) - t * e;
  return off.dot(off);
}

}  // namespace detail

// The squared distance between the segment from p to q and triangle abc: zero where they meet. RT: yes.
template <class T>
inline T segment_triangle_distance_squared(const detail::Of3<T>& p, const detail::Of3<T>& q, const detail::Of3<T>& a,
                                           const detail::Of3<T>& b, const detail::Of3<T>& c) {
  using detail::lane_min;
  using detail::Of3;
  const T zero = detail::zero_lanes<T>();
  const Of3<T> d = q - p;
  const Of3<T> ab = b - a;
  const Of3<T> bc = c - b;
  const Of3<T> ca = a - c;
  T best = lane_min(triangle_distance_squared<T>(p, a, b, c), triangle_distance_squared<T>(q, a, b, c));
  best = lane_min(best, detail::segment_segment_distance_squared<T>(p, d, a, ab));
  best = lane_min(best, detail::segment_segment_distance_squared<T>(p, d, b, bc));
  best = lane_min(best, detail::segment_segment_distance_squared<T>(p, d, c, ca));
  // The segment passes through the face: its ends are on different sides, and its line is on the same side of all three edges.
  const auto cross = [](const Of3<T>& x, const Of3<T>& y) {
    return Of3<T>{x.y * y.z - x.z * y.y, x.z * y.x - x.x * y.z, x.x * y.y - x.y * y.x};
  };
  const Of3<T> n = cross(ca, ab);
  const T side_p = n.dot(p - a);
  const T side_q = n.dot(q - a);
  const T eab = cross(a - p, b - p).dot(d);
  const T ebc = cross(b - p, c - p).dot(d);
  const T eca = cross(c - p, a - p).dot(d);
  const T low = lane_min(eab, lane_min(ebc, eca));
  const T high = detail::lane_max(eab, detail::lane_max(ebc, eca));
  const auto through = (low > zero) | (high < zero);
  const auto crosses = (side_p * side_q) <= zero;
  return (through & crosses) ? zero : best;
}

}  // namespace hapton
