#pragma once

#include <array>
#include <limits>
#include <span>

#include "core/geometry/contact_triangle.h"
#include "core/math/types.h"

namespace hapton {

// The directions in which a point at the apex, where triangles meet, can move: the tangent cone of the free space there (Rockafellar and
// Wets 1998, 6.A). On the unit sphere around the apex each triangle is an arc of a great circle. Arcs bound the region of directions that
// are free. The boundary of that region is a closed loop of pieces of arcs, each seen from one side. After a piece comes the first arc that
// a rotation about the end direction of the piece, through the free side, meets. Only directions count: the triangles may share edges,
// intersect, or end in free space.
//
// Directions are unit vectors in the triangles' frame. RT: yes; bounded by kMaxArcs and kMaxPieces. Threads: one.
class TangentCone {
 public:
  // A triangle has one arc if a corner is at the apex, two for an edge, four for its inside. find_boundary() is quadratic in the arcs.
  static constexpr int kMaxArcs = 96;
  static constexpr int kMaxPieces = 96;

  struct Piece {
    Vec3 from = Vec3::Zero();
    Vec3 to = Vec3::Zero();
    Vec3 normal = Vec3::Zero();  // unit, to the free side
    Vec3 back = Vec3::Zero();    // unit, at `to`, tangent to the piece, back along it
    double opening = 0.0;        // rad: the free angle at `to` between this piece and the next
  };
  struct Steepest {
    double slope = 0.0;             // direction.dot(pull), the largest
    Vec3 direction = Vec3::Zero();  // unit
    int piece = -1;                 // index in boundary(); -1: there is no direction
  };

  // Forgets all triangles.
  void begin(const Vec3& apex);
  // Adds a triangle. An edge or corner within `near` of the apex counts as at it. False: no room; no arc is added. Pre: the apex is on it.
  bool add(const ContactTriangle& shape, double near);
  // Finds the boundary of the region that contains the direction `inside`. False: there is none, or it does not close in kMaxPieces.
  bool find_boundary(const Vec3& inside);
  // Whether that loop goes through the arc nearest to `inside`. If not, it may be the boundary of another region.
  bool is_around_start() const { return is_around_start_; }

  const Vec3& apex() const { return apex_; }
  std::span<const Piece> boundary() const { return std::span(pieces_).first(piece_count_); }
  // The steepest direction on the boundary with a slope less than `below`. Slope -infinity: there is none. `pull` may have any length.
  Steepest find_steepest(const Vec3& pull, double below = std::numeric_limits<double>::infinity()) const;
  // Whether the boundary has a direction around which more than half of all directions are free.
  bool is_reentrant() const;
  // Whether the direction, which is on no arc, is inside the region: the nearest arc is a part of the boundary, seen from that side.
  bool contains(const Vec3& direction) const;

 private:
  struct Arc {
    Vec3 a, b, normal;  // a x b
  };
  // A position on the boundary and how it is followed from there.
  struct Walk {
    int arc = -1;
    bool ahead = true;      // towards its b
    bool on_normal = true;  // the normal of the arc points to the free side
    Vec3 from = Vec3::Zero();
    bool is_along(const Walk& other) const { return arc == other.arc && ahead == other.ahead && on_normal == other.on_normal; }
  };
  struct Turn {
    Walk walk;
    double opening = 0.0;
  };

  bool add_arc(const Vec3& a, const Vec3& b);
  void join_ends();
  bool walk_boundary(const Vec3& inside);
  Vec3 snapped_to_end(const Vec3& direction) const;
  bool add_arcs(const ContactTriangle& shape, double near);
  static bool is_on(const Arc& arc, const Vec3& direction);
  Vec3 find_end(int arc, bool ahead, const Vec3& from) const;
  Turn turn(const Vec3& at, const Vec3& back, const Vec3& up, bool is_end) const;
  bool find_start(const Vec3& inside, Walk& start) const;
  int find_repeated_piece(const Walk& here) const;

  Vec3 apex_ = Vec3::Zero();
  std::array<Arc, kMaxArcs> arcs_;
  int arc_count_ = 0;
  std::array<Arc, kMaxArcs> arcs_before_join_;  // copy of arcs_ before ends were joined
  std::array<Piece, kMaxPieces> pieces_;
  std::array<Walk, kMaxPieces> walks_;  // where each piece began
  int piece_count_ = 0;
  bool is_around_start_ = false;
};

}  // namespace hapton
