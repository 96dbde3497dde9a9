#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/types.h"

namespace hapton {

// Two triangles that may meet. Frames: any, one for both.
struct TrianglePair {
  std::array<Vec3, 3> a;
  std::array<Vec3, 3> b;
};

// Where two triangles meet. Two planes that cross share a line; what both triangles have of it is a segment (or a point, when they only
// touch), and each of its ends is where an edge of one pierces the other.
struct TriangleContact {
  bool meets = false;
  bool coplanar = false;      // they share an area, an edge or a point of one plane: begin and end are the two points of it farthest apart
  Vec3 begin = Vec3::Zero();  // begin -> end points along normal(a) x normal(b)
  Vec3 end = Vec3::Zero();
};

// Whether and where two closed triangles meet. Every decision is a sign of an exact determinant of the given corners, so touching edges,
// corners in the other's plane and coplanar pairs are decided as they are. Located: both ends within 2^-18 of the longest edge, plus one
// rounding of the coordinates themselves, however shallow the angle between the triangles. A triangle without area meets nothing: its edges
// belong to its neighbours. Pre: as orient3d. RT: yes (well under 1 us; some 10 us when the signs need exact arithmetic throughout).
// Source: Guigue & Devillers 2003; we differ in locating the segment too and in treating zeros by which corner is strictly highest or
// lowest.
TriangleContact intersect_triangles(const TrianglePair& pair) noexcept;

// Eight pairs side by side in single precision, each relative to a point of its own near it: what intersect_8 works on.
struct alignas(32) TrianglePairs8 {
  float a[3][3][8];  // [corner][axis][lane]
  float b[3][3][8];
};

// What intersect_8 found out.
struct alignas(32) TriangleContacts8 {
  float begin[3][8];  // [axis][lane]; only where meets says so
  float end[3][8];
  float error[8];        // both ends are at most this far from the exact ones
  std::uint8_t meets;    // bit a lane: certainly meets, and located to 0.1 % of the smaller triangle (its longest edge)
  std::uint8_t unclear;  // bit a lane: single precision cannot tell; ask intersect_triangles. Neither bit: certainly apart
};

// Rounds one pair into a lane, relative to its corner a[0]. RT: yes.
void pack_pair(const TrianglePair& pair, int lane, TrianglePairs8& pairs) noexcept;

// The same for eight pairs that follow each other, in fewer instructions.
void pack_8(const TrianglePair* pairs, TrianglePairs8& packed) noexcept;

// Eight pairs at once. Its certainties hold for all coordinates that round to those given (each within 2^-24 of its magnitude), so for
// the double precision pair that was packed too: every sign is taken only where it exceeds a bound on its error, derived in the .cpp.
// RT: yes, no branches.
void intersect_8(const TrianglePairs8& pairs, TriangleContacts8& contacts) noexcept;

// Many pairs: eight at once, and one by one where that is unclear. The same decisions as intersect_triangles, located to 0.1 % of
// the smaller triangle. Returns how many had to be asked one by one. Pre: contacts.size() >= pairs.size(). RT: yes.
std::size_t intersect_pairs(std::span<const TrianglePair> pairs, std::span<TriangleContact> contacts) noexcept;

}  // namespace hapton
