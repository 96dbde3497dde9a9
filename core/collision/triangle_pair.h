#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/types.h"

namespace hapton {

// Two triangles that may intersect. Frame: any, one for both.
struct TrianglePair {
  std::array<Vec3, 3> a;
  std::array<Vec3, 3> b;
};

// The intersection of two triangles. Two planes that cross share a line; the part of this line in both triangles is a segment (or a point,
// if they only touch). At each end of the segment an edge of one triangle crosses the other triangle.
struct TriangleContact {
  bool meets = false;
  bool coplanar = false;      // both lie in one plane: begin and end are the two points of the intersection that are farthest apart
  Vec3 begin = Vec3::Zero();  // valid if meets; begin -> end points along normal(a) x normal(b)
  Vec3 end = Vec3::Zero();
};

// Whether and where two closed triangles intersect. Every decision is the exact sign of a determinant of the given corners, so edges that
// touch, corners in the plane of the other triangle and coplanar pairs are decided exactly. Accuracy: each end within 2^-18 of the longest
// edge, plus one rounding of the coordinates, however small the angle between the triangles. A degenerate triangle intersects nothing: its
// edges belong to its neighbours. Pre: see orient3d. RT: yes (well under 1 us; about 10 us if all signs need exact arithmetic). Source:
// Guigue & Devillers 2003; we differ: the segment is located too, and zeros are treated by which corner is strictly highest or lowest.
TriangleContact intersect_triangles(const TrianglePair& pair) noexcept;

// Eight pairs in single precision, each relative to a point near it: the input of intersect_8.
struct alignas(32) TrianglePairs8 {
  float a[3][3][8];  // [corner][axis][lane]
  float b[3][3][8];
};

// The result of intersect_8.
struct alignas(32) TriangleContacts8 {
  float begin[3][8];  // [axis][lane]; valid where meets is set
  float end[3][8];
  float error[8];          // both ends are at most this far from the exact ones
  std::uint8_t meets;      // a bit per lane: certainly intersects, located to 0.1 % of the longest edge of the smaller triangle
  std::uint8_t undecided;  // a bit per lane: not certain in single precision; use intersect_triangles. Neither bit: certainly apart
};

// Rounds one pair into a lane, relative to its corner a[0]. RT: yes.
void pack_pair(const TrianglePair& pair, int lane, TrianglePairs8& pairs) noexcept;

// Rounds eight consecutive pairs into the eight lanes. Pre: pairs has eight elements. RT: yes.
void pack_8(const TrianglePair* pairs, TrianglePairs8& packed) noexcept;

// Intersects eight pairs. A certain result holds for all coordinates that round to those given (each within 2^-24 of its magnitude), so for
// the packed pair in double precision too: a sign counts only above a bound on its error, derived in the .cpp. RT: yes, no branches.
void intersect_8(const TrianglePairs8& pairs, TriangleContacts8& contacts) noexcept;

// Intersects many pairs, eight at once; undecided ones one by one. Same decisions as intersect_triangles, located to 0.1 % as in
// intersect_8. Returns the number of pairs done one by one. Pre: contacts.size() >= pairs.size(). RT: yes.
std::size_t intersect_pairs(std::span<const TrianglePair> pairs, std::span<TriangleContact> contacts) noexcept;

}  // namespace hapton
