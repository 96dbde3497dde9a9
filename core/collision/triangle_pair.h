#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/types.h"

namespace hapton {

// Two triangles that may intersect. Frames: any, one for both.
struct TrianglePair {
  std::array<Vec3, 3> a;
  std::array<Vec3, 3> b;
};

// The intersection of two triangles. Two planes that cross share a line; the part of it in both triangles is a segment (or a point, if they
// only touch), and each of its ends is where an edge of one crosses the other.
struct TriangleContact {
  bool meets = false;
  bool coplanar = false;      // both lie in one plane: begin and end are the two points of what they share that are farthest apart
  Vec3 begin = Vec3::Zero();  // begin -> end points along normal(a) x normal(b)
  Vec3 end = Vec3::Zero();
};

// Whether and where two closed triangles intersect. Every decision is a sign of an exact determinant of the given corners, so touching
// edges, corners in the other's plane and coplanar pairs are decided exactly. Accuracy: both ends within 2^-18 of the longest edge, plus
// one rounding of the coordinates, however small the angle between the triangles. A degenerate triangle intersects nothing: its edges
// belong to its neighbours. Pre: see orient3d. RT: yes (well under 1 us; about 10 us if all signs need exact arithmetic). Source: Guigue &
// Devillers 2003; we differ in locating the segment too and in treating zeros by which corner is strictly highest or lowest.
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
  std::uint8_t meets;      // bit per lane: certainly intersects, located to 0.1 % of the smaller triangle (its longest edge)
  std::uint8_t undecided;  // bit per lane: not certain in single precision; use intersect_triangles. Neither bit: certainly apart
};

// Rounds one pair into a lane, relative to its corner a[0]. RT: yes.
void pack_pair(const TrianglePair& pair, int lane, TrianglePairs8& pairs) noexcept;

// The same for eight consecutive pairs, in fewer instructions. Pre: pairs has eight elements. RT: yes.
void pack_8(const TrianglePair* pairs, TrianglePairs8& packed) noexcept;

// Eight pairs at once. Its certain results hold for all coordinates that round to those given (each within 2^-24 of its magnitude), so for
// the packed double precision pair too: a sign counts only if it exceeds a bound on its error, derived in the .cpp. RT: yes, no branches.
void intersect_8(const TrianglePairs8& pairs, TriangleContacts8& contacts) noexcept;

// Many pairs: eight at once, and one by one where that is undecided. Same decisions as intersect_triangles, located to 0.1 % of the smaller
// triangle. Returns the number of pairs done one by one. Pre: contacts.size() >= pairs.size(). RT: yes.
std::size_t intersect_pairs(std::span<const TrianglePair> pairs, std::span<TriangleContact> contacts) noexcept;

}  // namespace hapton
