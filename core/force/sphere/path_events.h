#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/gathered_triangles.h"

namespace hapton {

// The first event on a piece of a centre's path: a contact leaves its face, edge or vertex, or the sphere touches another triangle.
// A contact on a face that goes on to a face of the same plane causes no event: only its triangle changes. A view: all arguments of the
// constructor outlive this object. Pre: a path begins at the centre, and stays on the active contacts.
//
// Frame and units: TouchGeometry's local ones; times of the path, 0 to 1. RT: yes. `work`: is raised by the units of work (step_work.h).
class PathEvents {
 public:
  // Hysteresis at the boundary of a part: a contact leaves a face this far beyond its edge and enters it this far inside, and likewise for
  // edges and their ends, so that rounding does not alternate between two parts. 256 times the rounding of a local coordinate.
  static constexpr double kOnBoundary = 0x1p-44;

  // A boundary of the part that a contact is on (a point on it and the unit direction out of the part), and the part beyond it.
  struct Exit {
    Vec3 origin, direction;
    int slot = -1;  // the gathered triangle of the part beyond; -1: the same triangle
    int index = 0;  // of the edge or corner beyond, in that triangle; of a face beyond: its edge at the boundary
    Feature part = Feature::face;
  };
  struct Event {
    double time = 1.0;  // of the path
    int contact = -1;   // the contact that leaves its part, through `exit`; -1: none
    Exit exit;
    int slot = -1;  // the gathered triangle that is hit; -1: none
  };
  // A contact on a face, and its path over faces of the same plane: the contact where the path begins, and that on the last of these faces
  // before the time `until`. 0: the path does not leave the first face.
  struct LevelFaces {
    OffsetContact first, last;
    double until = 0.0;
  };
  // Memory for a search, which is large, so that its owner keeps it.
  struct Space {
    std::array<int, NearTriangles::kCapacity> candidates;  // slots of the triangles that a path may hit
    int count = 0;                                         // of candidates
    std::array<LevelFaces, 3> crossed;                     // by active contact, for the path of the last find()
  };

  PathEvents(ContactSet& contacts, GatheredTriangles& near, Space& space, int& work)
      : contacts_(contacts), near_(near), space_(space), work_(work) {}

  // The first event on the path, up to the time that `event` holds at the call. Contacts that cross faces of the same plane on the way are
  // then on the last of these. False: the triangles near the path cannot be gathered.
  bool find(const CentrePath& path, Event& event) noexcept;
  // Puts the contacts back that the last find() moved over level faces.
  void undo_level_faces() noexcept {
    for (int i = 0; i < contacts_.active_count(); ++i) {
      if (space_.crossed[i].until > 0.0) contacts_[i] = space_.crossed[i].first;
    }
  }
  // Moves the centre to the event. The path approximates the exact one, so Newton steps correct the time to that of contact or boundary.
  // `place(time)`: moves `centre` to its position on the exact path at that time.
  template <class Place>
  void place(const CentrePath& path, Event& event, const Vec3& centre, Place&& place) noexcept;

  // Distance from c along a straight direction to the boundary of the first contact's part, or to that of the last of the faces of the same
  // plane, and a quarter more, so that a path of that length passes it. Infinite: the boundary is farther than `most`.
  double distance_to_boundary(const Vec3& c, const Vec3& direction, double most) noexcept;
  // Whether a path over the face of the first contact, from c to `end`, stays on that face and meets nothing. Pre: its unit tangent turns
  // from `direction` to `direction_there` and never back.
  bool is_clear_over_face(const Vec3& c, const Vec3& end, const Vec3& direction, const Vec3& direction_there) noexcept;

  // Whether a centre at c is at the offset from the plane of a face, within rounding.
  bool is_level_at(const OffsetContact& face, const Vec3& c) const noexcept;
  static bool is_over(const ContactTriangle& shape, const Vec3& c) noexcept;
  // The exit from a face over its edge k.
  static Exit edge_of(const ContactTriangle& face, int k) noexcept {
    return {face.corner(k), face.edge(k).cross(face.normal()) / face.length(k), -1, k, Feature::edge};
  }
  // When a path over a face leaves it between these times, and over which edge; kNever: it does not.
  static double time_off_face(const CentrePath& path, const ContactTriangle& face, double from, double until, Exit& exit) noexcept;

 private:
  static constexpr double kCoplanar = 0x1p-50;  // distance between planes that counts as rounding

  // The two planes through the face or edge of a contact that are normal to the direction to the centre, at a path's start and at its end.
  struct TangentSpan {
    Vec3 origin;                 // a point on both
    std::array<Vec3, 2> normal;  // unit, towards the centre
  };
  struct Tangents {
    std::array<TangentSpan, 3> spans;
    int count = -1;  // -1: not found yet
  };

  void find_first_exit(const CentrePath& path, int contact, CentrePath::Prefix& prefix, Event& event) noexcept;
  bool cross_level_faces(const CentrePath& path, double until, OffsetContact& contact, Event& event) const noexcept;
  bool find_level_face(const OffsetContact& contact, int edge, const Vec3& c, OffsetContact& level) const noexcept;
  void move_to_last_level_face(const CentrePath& path, const Event& event) noexcept;
  bool cannot_stop(int slot, const Vec3& from, bool is_on_plane) noexcept;
  void find_tangents(const CentrePath& path, Tangents& tangents) const noexcept;
  bool is_below(const Tangents& tangents, const ContactTriangle& shape) const noexcept;
  bool find_candidates(const CentrePath& path, double reach, CentrePath::Prefix& prefix) noexcept;
  void note_candidates(const Vec3& from, const Vec3& to, double reach) noexcept;
  template <class Visit>
  void visit_exits(const OffsetContact& contact, Visit&& visit) noexcept;
  bool is_past_needle(const ContactTriangle& shape, int edge, const Vec3& c) const noexcept;

  ContactSet& contacts_;
  GatheredTriangles& near_;
  Space& space_;
  int& work_;
};

template <class Place>
void PathEvents::place(const CentrePath& path, Event& event, const Vec3& centre, Place&& place) noexcept {
  constexpr int kMaxRounds = 6;  // of Newton's method; after them the event stays where it then is
  place(event.time);
  const bool is_hit = event.slot >= 0;
  if ((!is_hit && event.contact < 0) || (is_hit && path.is_straight()) || event.time <= 0.0) return;
  // Where the cubic stops, the exact path may already have crossed the triangle: the distance is positive on the side where the cubic is.
  const Vec3 side = is_hit ? near_.shape(event.slot).separation(path.at(event.time)).normal : Vec3(Vec3::Zero());
  for (int i = 0; i < kMaxRounds; ++i) {
    ++work_;
    double gap = 0.0;
    double rate = 0.0;
    if (is_hit) {
      const Separation at = near_.shape(event.slot).separation(centre);
      const double sign = at.normal.dot(side) < 0.0 ? -1.0 : 1.0;
      gap = sign * at.distance - contacts_.offset();
      rate = sign * at.normal.dot(path.slope(event.time));
    } else {
      gap = kOnBoundary - event.exit.direction.dot(centre - event.exit.origin);
      rate = -event.exit.direction.dot(path.slope(event.time));
    }
    if (std::fabs(gap) <= (is_hit ? 0.125 * contacts_.clearance().slop : 0.25 * kOnBoundary) || !(rate < 0.0)) return;
    const double time = std::clamp(event.time - gap / rate, 0.0, 1.0);
    if (time == event.time) return;
    event.time = time;
    place(time);
  }
}

}  // namespace hapton
