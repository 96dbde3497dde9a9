#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/geometry/contact_triangle.h"

namespace hapton {

// A short piece of the way of a sphere's centre over an offset surface: a cubic with the true ends and tangents, time 0 to 1, brought back
// onto the one or two parts of that surface that guide it. Over an arc of a radius r that turns by an angle a the cubic is r a^4 / 384 off.
// RT: yes.
class CentrePath {
 public:
  // A sphere may come so near before a triangle stops it, and it stops where it is just in contact. Between, what grazes passes.
  struct Keep {
    double offset = 0.0;     // the distance of a contact
    double slop = 0.0;       // less by this is never reached; half of it may be used up by what only grazes
    double tolerance = 0.0;  // of distances
  };
  // A plane, cylinder or sphere on which the centre keeps the distance `offset` from a plane through `origin`, a line or a point.
  struct Guide {
    enum class Round : std::uint8_t { plane, line, point };
    Round round = Round::plane;
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::Zero();  // unit; of the plane: its normal, towards the centre
    double offset = 0.0;
    // From the plane, line or point, with the direction in which that grows; zero where there is none.
    double distance_to(const Vec3& p, Vec3& normal) const noexcept;
  };
  static constexpr double kNever = 2.0;

  CentrePath() = default;
  static CentrePath straight(const Vec3& from, const Vec3& to) noexcept;
  static CentrePath curved(const Vec3& from, const Vec3& to, const Vec3& slope_from, const Vec3& slope_to) noexcept;
  // Pre: at most two, not parallel where the path leads.
  void keep_on(const Guide& guide) { guides_[static_cast<std::size_t>(guide_count_++)] = guide; }

  const Vec3& start() const { return start_; }
  const Vec3& end() const { return end_; }
  Vec3 at(double time) const noexcept;
  // The derivative: along the guides to rounding, its length to 2^-11 of itself.
  Vec3 slope(double time) const noexcept;
  // No point of the path is farther from the chord.
  double bulge() const { return 0.125 * bulge_; }
  bool is_straight() const { return bend_ == 0.0; }

  // The beginning of the path, until a time: where and how it goes there. What looks at many triangles works it out once.
  struct Head {
    double until = 1.0;
    Vec3 end = Vec3::Zero();
    Vec3 slope = Vec3::Zero();  // there
  };
  Head head(double until) const noexcept;

  // The first time in [from, until] at which direction . (p - origin) exceeds `margin` on its way up, or kNever.
  double time_to_pass(const Vec3& origin, const Vec3& direction, double margin, double from, double until) const noexcept;
  // The same in the head.
  double time_to_pass(const Vec3& origin, const Vec3& direction, double margin, const Head& head) const noexcept;

  // When a triangle stops the centre, in [0, until]. The distance to a triangle is convex, so along the path it stays above the
  // parabola that it begins with, less what the path bends, and above that which it ends with: most triangles need no search. Every step of
  // the search is safe, and near the hit it is Newton's. It ends after 64 of them.
  // `held`: a bit for each corner that is of a part which guides the path: such a corner is never nearer than the part.
  struct Block {
    double time = kNever;
    bool hits = false;  // else that far it is known to be free
  };
  Block find_block(const ContactTriangle& triangle, const Keep& keep, unsigned held, const Head& head, int& tests) const noexcept;

 private:
  struct Level {
    double distance = 0.0;
    double tolerance = 0.0;
  };
  Block find_below(const ContactTriangle& triangle, const Level& level, unsigned held, double from, double until,
                   int& tests) const noexcept;
  double least_by_ends(const ContactTriangle& triangle, const Separation& start, double approach, const Head& head) const noexcept;
  struct Border {
    Vec3 origin, direction;
    double margin;
    double beyond(const Vec3& p) const { return direction.dot(p - origin) - margin; }
  };
  struct Range {
    double low, high, at_low, at_high;  // times, and how far beyond then
  };
  double find_passing(const Border& border, Range range) const noexcept;
  double guess_passing(const Border& border, Range range) const noexcept;
  Vec3 cubic_at(double time) const { return start_ + time * (rate_[0] + time * (rate_[1] + time * rate_[2])); }
  double find_crest(const Vec3& direction, double low, double high) const noexcept;
  double time_off_corner(const ContactTriangle& triangle, int corner, double from, double until) const noexcept;

  double bend_towards(const Vec3& normal) const { return std::fabs(normal.dot(chord_)) * bend_along_ + bend_across_; }
  void bring_back(Vec3& p) const noexcept;
  double bring_nearer(Vec3& p) const noexcept;
  Vec3 slope(double time, const Vec3& p) const noexcept;  // p: at that time
  Vec3 cubic_slope(double time) const { return rate_[0] + time * (2.0 * rate_[1] + 3.0 * time * rate_[2]); }

  Vec3 start_ = Vec3::Zero();
  Vec3 end_ = Vec3::Zero();
  std::array<Vec3, 3> rate_;   // start + rate 0 t + rate 1 t^2 + rate 2 t^3
  double bend_ = 0.0;          // the most of the second derivative,
  Vec3 chord_ = Vec3::Zero();  // unit
  double bend_along_ = 0.0;    // of its part along the chord: how unevenly it is gone along,
  double bend_across_ = 0.0;   // and of the rest
  double bulge_ = 0.0;
  std::array<Guide, 2> guides_;
  int guide_count_ = 0;
};

}  // namespace hapton
