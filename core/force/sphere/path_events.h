#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/gathered_triangles.h"

namespace hapton {

// The first event on a piece of a centre's path: a contact leaves its face, edge or vertex, or the sphere touches another triangle.
// Contacts on faces are followed over the faces of the same plane, where nothing changes but the triangle. A view: all that it is made from
// outlives it. Pre: a path begins at the centre, and stays on the active contacts.
//
// Frame and units: TouchGeometry's local ones; times of the path, 0 to 1. RT: yes. `work`: is raised by the units of work (step_work.h).
class PathEvents {
 public:
  // Hysteresis at the boundary of a part: a contact leaves a face this far beyond its edge and enters it this far inside, and likewise for
  // edges and their ends, so that rounding does not alternate between two parts. 256 times the rounding of a local coordinate.
  static constexpr double kOnBoundary = 0x1p-44;

  // A boundary of the part that the contact is on, and what lies beyond it.
  struct Exit {
    Vec3 origin, direction;
    int slot = -1;  // of the gathered triangles; -1: the same triangle
    int index = 0;
    Feature part = Feature::face;
  };
  struct Event {
    double time = 1.0;  // of the path
    int contact = -1;   // the contact that leaves its part, through `exit`; -1: none
    Exit exit;
    int slot = -1;  // the triangle that is hit; -1: none
  };
  // A contact on a face where a path crosses faces of the same plane: before the path, and the last of them before `until`. 0: it crosses
  // none.
  struct LevelFaces {
    OffsetContact first, last;
    double until = 0.0;
  };
  // What a search writes; large.
  struct Space {
    std::array<int, NearTriangles::kCapacity> candidates;  // slots that a path may hit
    int count = 0;                                         // of these
    std::array<LevelFaces, 3> crossed;                     // by active contact, of the path of the last find()
  };

  PathEvents(ContactSet& contacts, GatheredTriangles& near, Space& space, int& work)
      : contacts_(contacts), near_(near), space_(space), work_(work) {}

  // The first event on the path, up to the time in `event`. Contacts that cross level faces on the way are then on the last of these.
  // False: it cannot be computed.
  bool find(const CentrePath& path, Event& event) noexcept;
  // Puts the contacts back that the last find() moved over level faces.
  void undo_level_faces() noexcept {
    for (int i = 0; i < contacts_.active_count(); ++i) {
      if (space_.crossed[i].until > 0.0) contacts_[i] = space_.crossed[i].first;
    }
  }
  // Places the centre at the event. The path approximates the exact one, so Newton steps lead to the point of contact or the boundary.
  // `place`: moves `centre` to where it is on the exact path at a time.
  template <class Place>
  void place(const CentrePath& path, Event& event, const Vec3& centre, Place&& place) noexcept;

  // Distance from c along a straight direction to the boundary of the first contact's part, over level faces to that of the last, with a
  // margin. Infinite if it is farther than `most`.
  double distance_to_boundary(const Vec3& c, const Vec3& direction, double most) noexcept;
  // Whether a path over the face of the first contact, from c to `end`, stays on that face and meets nothing. Its unit tangent turns from
  // `direction` to `direction_there` and never back.
  bool is_clear_over_face(const Vec3& c, const Vec3& end, const Vec3& direction, const Vec3& direction_there) noexcept;

  // Whether the centre at c is in contact with a face within rounding.
  bool is_level_at(const OffsetContact& face, const Vec3& c) const noexcept;
  static bool is_over(const ContactTriangle& shape, const Vec3& c) noexcept;
  // The way out of a face over its edge k.
  static Exit edge_of(const ContactTriangle& face, int k) noexcept {
    return {face.corner(k), face.edge(k).cross(face.normal()) / face.length(k), -1, k, Feature::edge};
  }
  // When a path over a face leaves it between these times, and over which edge; kNever: it does not.
  static double time_off_face(const CentrePath& path, const ContactTriangle& face, double from, double until, Exit& exit) noexcept;

 private:
  static constexpr double kCoplanar = 0x1p-50;  // distance between planes that counts as rounding

  // The tangent planes of the parts below a contact that the centre stays on along a path, at its start and its end.
  struct TangentSpan {
    Vec3 origin;                 // on both
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
  bool find_candidates(const CentrePath& path, double near, CentrePath::Prefix& prefix) noexcept;
  void note_candidates(const Vec3& from, const Vec3& to, double near) noexcept;
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
  constexpr int kMaxRounds = 6;  // of Newton's method; then the event stays where it is
  place(event.time);
  const bool is_hit = event.slot >= 0;
  if ((!is_hit && event.contact < 0) || (is_hit && path.is_straight()) || event.time <= 0.0) return;
  // Where the cubic approximation stops, the exact path may already have crossed the triangle: the distance is signed by the cubic's side.
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
