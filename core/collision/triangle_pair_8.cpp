#include "core/collision/triangle_pair.h"
#include "core/math/float8.h"

// The steps of intersect_triangles (triangle_pair.cpp) in eight lanes, without branches, and with a bound on the error of every number
// whose sign decides. u = 2^-24.
//
// Corners have an error of u times their length, which `bound` limits; a difference of two, rounded again, has an error of eta = 4 u bound.
// A determinant whose rows have lengths up to k, l and m then has an error of at most
//   eta (k l + k m + l m)  from its rows (Hadamard), with k, l, m one eta longer to cover the products of errors, and
//   5 u k l m              from its arithmetic: a component of a cross product fma(a, b, -(c d)) has an error of u (|c d| + |a b - c d|),
//                          together 2 u k l, times m; three roundings in the dot product, 3 u k l m.
// A crossing point is base + t dir with t = d0 / (d0 - d1), both heights d with an error of E. The error of t is E / |d0 - d1| (exactly
// so, with the computed denominator) plus 3 u, that of dir is eta, that of base u bound; the sum adds another u bound.

namespace hapton {
namespace {

struct Vec8 {
  Float8 x, y, z;
};

const Float8 kSign = Float8(-0.0F);

Float8 magnitude(Float8 x) { return and_not(kSign, x); }

Vec8 load(const float from[3][8]) { return {Float8::load(from[0]), Float8::load(from[1]), Float8::load(from[2])}; }
void store(const Vec8& v, float into[3][8]) {
  store(into[0], v.x);
  store(into[1], v.y);
  store(into[2], v.z);
}
Vec8 minus(const Vec8& a, const Vec8& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Float8 dot(const Vec8& a, const Vec8& b) { return fma(a.z, b.z, fma(a.y, b.y, a.x * b.x)); }
Vec8 cross(const Vec8& a, const Vec8& b) { return {fms(a.y, b.z, a.z * b.y), fms(a.z, b.x, a.x * b.z), fms(a.x, b.y, a.y * b.x)}; }
Float8 squared(const Vec8& a) { return dot(a, a); }

// `other` in the lanes where the sign bit of the mask is set, `one` in the others.
Float8 choose(Float8 one, Float8 other, Float8 mask) { return select(mask, other, one); }
Vec8 choose(const Vec8& one, const Vec8& other, Float8 mask) {
  return {choose(one.x, other.x, mask), choose(one.y, other.y, mask), choose(one.z, other.z, mask)};
}

// A triangle, renumbered in cycle so that the corner that is alone on its side of the other triangle's plane comes first.
struct Turned8 {
  Vec8 first, second, third;
  Float8 height[3];
};

Turned8 turn(const Vec8 corner[3], const Float8 height[3]) {
  const Float8 differ_01 = height[0] ^ height[1];
  const Float8 differ_02 = height[0] ^ height[2];
  const Float8 second_alone = and_not(differ_02, differ_01);
  const Float8 third_alone = and_not(differ_01, differ_02);
  const auto pick = [&](const auto& none, const auto& second, const auto& third) {
    return choose(choose(none, second, second_alone), third, third_alone);
  };
  return {pick(corner[0], corner[1], corner[2]),
          pick(corner[1], corner[2], corner[0]),
          pick(corner[2], corner[0], corner[1]),
          {pick(height[0], height[1], height[2]), pick(height[1], height[2], height[0]), pick(height[2], height[0], height[1])}};
}

// The bound on a determinant's error (top of this file), with the rounding of the bound itself. Pre: k, l, m are already one eta longer.
Float8 determinant_error(Float8 eta, Float8 k, Float8 l, Float8 m) {
  const Float8 pairs = k * l + m * (k + l);
  return 1.01F * eta * pairs + 5.1F * 0x1p-24F * k * (l * m);
}

struct Heights {
  Float8 height[3];
  Float8 are_signs_certain;  // every sign is certain
  Float8 is_beside;          // all three certainly on one side
};

Heights heights_over(const Vec8& normal, const Vec8& on_plane, const Vec8 corner[3], Float8 error) {
  Heights h;
  Float8 least = __builtin_huge_valf();
  for (int i = 0; i < 3; ++i) {
    h.height[i] = dot(normal, minus(corner[i], on_plane));
    least = min(least, magnitude(h.height[i]));
  }
  h.are_signs_certain = least > error;
  const Float8 differ = (h.height[0] ^ h.height[1]) | (h.height[0] ^ h.height[2]);
  h.is_beside = and_not(differ, h.are_signs_certain);
  return h;
}

struct Pierced {
  Vec8 point;
  Float8 t_error;  // E / |d0 - d1|: error of t
};

Pierced pierce(const Vec8& base, const Vec8& direction, Float8 d0, Float8 d1, Float8 error) {
  const Float8 inverse = 1.0F / (d0 - d1);
  const Float8 t = d0 * inverse;
  return {{fma(t, direction.x, base.x), fma(t, direction.y, base.y), fma(t, direction.z, base.z)}, error * magnitude(inverse)};
}

}  // namespace

void intersect_8(const TrianglePairs8& pairs, TriangleContacts8& contacts) noexcept {
  const Vec8 a[3] = {load(pairs.a[0]), load(pairs.a[1]), load(pairs.a[2])};
  const Vec8 b[3] = {load(pairs.b[0]), load(pairs.b[1]), load(pairs.b[2])};
  const Vec8 ab = minus(a[1], a[0]);
  const Vec8 ac = minus(a[2], a[0]);
  const Vec8 de = minus(b[1], b[0]);
  const Vec8 df = minus(b[2], b[0]);

  // Bounds on lengths: of edges, of the distance between the triangles, of corners.
  const Float8 edge_a = sqrt(max(max(squared(ab), squared(ac)), squared(minus(a[2], a[1]))));
  const Float8 edge_b = sqrt(max(max(squared(de), squared(df)), squared(minus(b[2], b[1]))));
  const Float8 bound = sqrt(max(squared(a[0]), squared(b[0]))) + max(edge_a, edge_b);
  const Float8 eta = 4.1F * 0x1p-24F * bound;
  const Float8 two_eta = eta + 1.1F * eta;
  const Float8 k = edge_a + two_eta;
  const Float8 l = edge_b + two_eta;
  const Float8 between = sqrt(squared(minus(b[0], a[0]))) + two_eta;
  const Float8 error_a = determinant_error(eta, l, l, between + k);  // bounds the error of a's heights over b's plane
  const Float8 error_b = determinant_error(eta, k, k, between + l);

  const Heights over_b = heights_over(cross(de, df), b[0], a, error_a);
  const Heights over_a = heights_over(cross(ab, ac), a[0], b, error_b);
  const Turned8 p = turn(a, over_b.height);
  const Turned8 q = turn(b, over_a.height);

  // Along D (see intersect_triangles) the crossing points come in the order a's third, second corner if a is on top; b's in the reverse.
  const Float8 a_below = p.height[0];  // sign bit set: the first corner is the lowest
  const Float8 b_below = q.height[0];
  const Vec8 low_a = minus(choose(p.third, p.second, a_below), p.first);
  const Vec8 high_a = minus(choose(p.second, p.third, a_below), p.first);
  const Vec8 low_b = minus(choose(q.second, q.third, b_below), q.first);
  const Vec8 high_b = minus(choose(q.third, q.second, b_below), q.first);
  const Vec8 firsts = minus(q.first, p.first);
  const Vec8 low_turn = cross(low_a, firsts);
  const Vec8 high_turn = cross(high_a, firsts);
  const Float8 order_sign = (a_below ^ b_below) & kSign;
  // > 0: b's crossing point comes later along D than a's.
  const Float8 low_high = dot(high_b, low_turn) ^ order_sign;
  const Float8 high_low = dot(low_b, high_turn) ^ order_sign;
  const Float8 low_low = dot(low_b, low_turn) ^ order_sign;
  const Float8 high_high = dot(high_b, high_turn) ^ order_sign;
  const Float8 order_error = determinant_error(eta, k, l, between + (k + l));
  const Float8 apart = ((low_high ^ kSign) > order_error) | (high_low > order_error);
  const Float8 least_order = min(min(magnitude(low_high), magnitude(high_low)), min(magnitude(low_low), magnitude(high_high)));
  const Float8 heights_certain = over_b.are_signs_certain & over_a.are_signs_certain;
  const Float8 certain = (least_order > order_error) & heights_certain;

  // begin: the later of the two low ends; end: the earlier of the two high ends. The sign bits of these masks select b's.
  const Float8 begin_on_b = low_low ^ kSign;
  const Float8 end_on_b = high_high;
  const Float8 low_height_a = choose(p.height[2], p.height[1], a_below);
  const Float8 high_height_a = choose(p.height[1], p.height[2], a_below);
  const Float8 low_height_b = choose(q.height[1], q.height[2], b_below);
  const Float8 high_height_b = choose(q.height[2], q.height[1], b_below);
  const Pierced begin =
      pierce(choose(p.first, q.first, begin_on_b), choose(low_a, low_b, begin_on_b), choose(p.height[0], q.height[0], begin_on_b),
             choose(low_height_a, low_height_b, begin_on_b), choose(error_a, error_b, begin_on_b));
  const Pierced end =
      pierce(choose(p.first, q.first, end_on_b), choose(high_a, high_b, end_on_b), choose(p.height[0], q.height[0], end_on_b),
             choose(high_height_a, high_height_b, end_on_b), choose(error_a, error_b, end_on_b));
  const Float8 shift = max(k, l) * (max(begin.t_error, end.t_error) + 4.0F * 0x1p-24F) + 8.0F * 0x1p-24F * bound;
  const Float8 error = 1.75F * shift;  // above sqrt(3): from the error of a component to that of the length
  const Float8 located = 0.00099F * min(edge_a, edge_b) > error;

  const Float8 is_beside = over_b.is_beside | over_a.is_beside;
  const Float8 misses = is_beside | (apart & heights_certain);
  const Float8 meets = and_not(misses, certain & located);
  contacts.meets = static_cast<std::uint8_t>(sign_bits(meets));
  contacts.undecided = static_cast<std::uint8_t>(~sign_bits(meets | misses));
  store(begin.point, contacts.begin);
  store(end.point, contacts.end);
  store(contacts.error, error);
}

void pack_pair(const TrianglePair& pair, int lane, TrianglePairs8& pairs) noexcept {
  const Vec3& origin = pair.a[0];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      pairs.a[i][k][lane] = static_cast<float>(pair.a[i][k] - origin[k]);
      pairs.b[i][k][lane] = static_cast<float>(pair.b[i][k] - origin[k]);
    }
  }
}

void pack_8(const TrianglePair* pairs, TrianglePairs8& packed) noexcept {
  for (int lane = 0; lane < 8; ++lane) pack_pair(pairs[lane], lane, packed);
}

}  // namespace hapton
