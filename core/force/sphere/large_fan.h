#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/force/sphere/gathered_triangles.h"
#include "core/force/sphere/local_minimum.h"

namespace hapton {

// A sphere that touches a fan, and moves over it.
struct SphereOnFan {
  ContactSet& contacts;
  GatheredTriangles& near;
  Vec3& centre;
  bool& is_descending;  // it moves towards a device that does not move
  int& work;            // units, in this step (step_work.h)
  int most_work;
};

// Moves a sphere over the faces of a large fan that is convex or hollow as seen by the sphere (SurfaceAdjacency), without an event at each
// of its triangles. Keeps from step to step what it has found out about the fan.
//
// Frame and units: TouchGeometry's local ones. RT: yes, except for the constructor.
class LargeFan {
 public:
  // `geometry` outlives this object.
  explicit LargeFan(const TouchGeometry& geometry) : geometry_(geometry) {
    if (geometry.may_have_large_fans()) planes_.resize(NearTriangles::kCapacity);
  }

  enum class Crossing : std::uint8_t {
    none,    // the sphere is on no such fan, or this gets it no farther: the follower goes on with events
    convex,  // it has rolled from face to face
    hollow,  // it has gone straight to where the device holds it
  };
  // Whether the scene may have large fans; if not, cross() does nothing.
  bool exists() const { return !planes_.empty(); }
  // Follows the device from `time` on, on its way from `from` (0) to `to` (1). The centre is valid at the new `time`, whatever is returned.
  Crossing cross(SphereOnFan on, const Vec3& from, const Vec3& to, double& time) noexcept;
  // Call when the set of triangles has changed. Pre: exists() still holds, or still does not.
  void forget() { room_.room = -1.0; }

 private:
  // While the sphere's centre is within `room` of `at`, only the fan around `tip` can come nearer to the sphere than allowed.
  struct FanRoom {
    Vec3 tip = Vec3::Zero();
    Vec3 at = Vec3::Zero();
    double room = -1.0;
    std::uint32_t mesh = 0;
    std::uint32_t vertex = 0;  // of the tip, in the mesh
    bool back = false;         // the side that the sphere is on
    int planes = 0;            // number of planes near the sphere, in planes_; hollow fans only
  };
  // Where a device holds a sphere in a hollow fan: the centre, and its contacts.
  struct HollowPlace {
    Vec3 centre = Vec3::Zero();
    int count = 0;
    std::array<OffsetContact, 3> contacts;
  };
  struct FanPlane {
    Vec3 normal;  // towards the sphere
    std::uint32_t triangle;
  };

  int fan_corner(const OffsetContact& face) const noexcept;
  bool is_hollow_fan(const OffsetContact& face) const noexcept;
  bool touches_one_fan(const SphereOnFan& on) const noexcept;
  bool is_alone_with_fan(SphereOnFan& on, const OffsetContact& face, const Vec3& towards) noexcept;
  double share_in_fan_room(const Vec3& c, const Vec3& motion) const noexcept;
  bool cross_convex_fan(SphereOnFan& on, const Vec3& from, const Vec3& to, double& time) noexcept;
  bool cross_fan_edge(const SphereOnFan& on, int edge, const Vec3& device, OffsetContact& face, Vec3& c) const noexcept;
  bool cross_hollow_fan(SphereOnFan& on, const Vec3& from, const Vec3& to, double& time) noexcept;
  static void move_in_hollow_fan(SphereOnFan& on, const HollowPlace& place, bool descends) noexcept;
  bool find_in_hollow_fan(SphereOnFan& on, const Vec3& device, HollowPlace& place) noexcept;
  int find_lowest_plane(SphereOnFan& on, const Vec3& c, double& height) noexcept;

  const TouchGeometry& geometry_;
  FanRoom room_;
  std::vector<FanPlane> planes_;  // as many as NearTriangles::kCapacity if the scene may have large fans; else empty
};

}  // namespace hapton
