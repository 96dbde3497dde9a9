#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/force/reference/half_space_projection.h"
#include "core/force/touch_scene.h"
#include "core/geometry/closest_point.h"

namespace hapton {

// The proxy of the reference: where it is, what it is in contact with, and how it moves to an equilibrium for one device position.
// All lengths in local units: the scene's diagonal lies in (1/2, 1]. The caller names the triangles that can be met.
// A point probe is a sphere of the radius kPointRadius, so distances decide and never signs: no edge, corner or crack narrower than that
// lets it through. What that radius adds to the place is taken off again by `surface_place`. RT: no heap, lock or system call after
// construction, but no bound on time.
class ReferenceProxy {
 public:
  static constexpr double kPointRadius = 0x1p-32;  // 2^16 times what a distance errs by

  struct Face {
    PreparedTriangle shape;
    std::uint32_t triangle = 0;
    std::uint32_t object = 0;
  };
  struct Contact {
    Face face;
    ClosestPoint near;
  };
  // All that the proxy remembers.
  struct State {
    Vec3 place = Vec3::Zero();
    std::vector<Contact> contacts;
    Material material;  // of the contact, by the multipliers
    bool free = true;
    bool sliding = false;
  };
  // How it may move, beside what the materials say.
  struct Rules {
    bool friction = true;
    bool tips_borders = true;  // a proxy on the border of a face may stand on the edge
    // Where a local minimum ends it follows the steepest way over the surface to the next. False: it may fly straight over convex edges, to
    // whatever minimum that leads; with friction it never does.
    bool keeps_to_surface = true;
  };
  struct Counters {
    std::uint64_t substeps = 0;      // that had triangles near
    std::uint64_t motions = 0;       // straight pieces of the proxy's path
    std::uint64_t most_motions = 0;  // in one descent
    std::uint64_t unconverged = 0;   // descents stopped by the bound on motions: a valid proxy, short of the minimum
    std::uint64_t escapes = 0;       // corners left that only the probe's radius had closed
    std::uint64_t infeasible = 0;    // projections that rounding left without a solution
  };

  // `probe_radius` in local units, zero for a point. `most_faces`: as many can be added.
  ReferenceProxy(double probe_radius, std::vector<Material> materials, std::size_t most_faces);

  void clear_faces() noexcept;
  void add_face(const Face& face) noexcept;
  std::size_t faces() const { return faces_.size(); }

  // Forgets all contact and puts the proxy there.
  void place_free(const Vec3& p) noexcept;
  // Forgets all contact and puts the proxy where something may hold it.
  void place_held(const Vec3& p, bool sliding) noexcept;

  // Puts a point probe under friction where p stands on the surface, near by: in contact with the faces that are nearest to p. False, and
  // held with no contact, where there is no such place or no need of one. Pre: the faces there have been added.
  bool place_on_surface(const Vec3& p, bool sliding) noexcept;

  // Friction: where it stands is not told by the device alone, but by the way there.
  bool has_memory() const { return !frictionless_; }
  void set_sliding(bool sliding) noexcept { state_.sliding = sliding; }

  // One sub-step: the device has moved straight between the two, and the proxy moves to its equilibrium for the second.
  void follow(const Vec3& device_from, const Vec3& device_to, const Rules& rules) noexcept;

  const State& state() const { return state_; }
  // Copies into memory that is there. Pre: `to` was made by make_state().
  void save(State& to) const noexcept { to = state_; }
  void restore(const State& from) noexcept { state_ = from; }
  State make_state() const;

  // Where the proxy is on the surface itself. A sphere: its place. A point: its place less its radius, along the contacts that hold it
  // against the device; the device itself where that would pull it.
  Vec3 surface_place(const Vec3& device) noexcept;

  double rest() const { return rest_; }  // distance of the proxy's centre from what it is in contact with
  const Counters& counters() const { return counters_; }
  void clear_counters() { counters_ = {}; }

 private:
  struct Box {
    Vec3 low, high;
  };
  struct Pull {
    HalfSpaceProjection motion;  // from the proxy
    const Contact* strongest = nullptr;
  };

  // Shares of a motion between which it is over a face.
  struct Stay {
    double from, until;
  };
  struct FirstMet {
    double until = 1.0;  // share of the motion
    const Face* face = nullptr;
  };

  // A face at an edge.
  struct Side {
    Vec3 normal = Vec3::Zero();
    Vec3 inward = Vec3::Zero();
  };
  enum class AtVertex : std::uint8_t { elsewhere, held, left };

  void list_local_faces() noexcept;
  bool is_local(const Vec3& p, double reach) const noexcept;
  template <class FaceAt>
  FirstMet find_first(const Vec3& motion, std::size_t count, const FaceAt& face_at) const noexcept;
  void drag(const Vec3& device_from, const Vec3& device_to) noexcept;
  void descend(const Vec3& device) noexcept;
  bool escape(const Vec3& device) noexcept;
  bool is_on_open_face() const noexcept;
  void collect_near(const Vec3& p, double within) noexcept;
  bool lift(const Vec3& start, double height) noexcept;
  const std::vector<Vec3>& directions_out(const Vec3& start, const Vec3& pull, double within) noexcept;
  bool cross_free_space(const Vec3& device) noexcept;
  void update_contacts() noexcept;
  void forget_borders_of_faces() noexcept;
  void meet_face_below() noexcept;
  Pull project_pull(const Vec3& pull) noexcept;
  double pressure_of(double push) const noexcept;
  Material material_of(const Pull& pull) const noexcept;
  Vec3 limit_by_friction(const Pull& pull) noexcept;
  Vec3 cut_at_border(const Pull& pull, const Vec3& motion) noexcept;
  double share_on_feature(const Contact& contact, const Vec3& motion) noexcept;
  double share_on_plane(const Contact& contact, const Vec3& motion) noexcept;
  bool has_friction() const { return !frictionless_ && rules_.friction; }
  bool keeps_to_surface() const { return rules_.keeps_to_surface || has_friction(); }
  const Vec3* find_vertex(const Pull& pull) const noexcept;
  bool leave_vertex(const Vec3& device, const Pull& pull) noexcept;
  bool find_concave_edge(const Pull& pull, Vec3& on_edge, std::array<Side, 2>& sides) noexcept;
  bool is_held_at_edge(const Vec3& device, const Pull& pull) noexcept;
  AtVertex slip_from_vertex(const Vec3& device, const Pull& pull) noexcept;
  bool leave_along(const Vec3& vertex, const Vec3& way, const Vec3& device) noexcept;
  bool exceeds_friction(double way, double depth, const Material& material) noexcept;
  Vec3 find_steepest(const Vec3& vertex, const Vec3& to_device) noexcept;
  bool roll(const Vec3& device, const Pull& pull) noexcept;
  bool tip_over(const Vec3& device, const Pull& pull) noexcept;
  bool tip_over(const Vec3& device, const Contact& contact) noexcept;
  Vec3 pivot_of(const Contact& contact) const noexcept;
  static Vec3 edge_of(const Contact& contact) noexcept;
  static Vec3 across_feature(const Contact& contact, const Vec3& v) noexcept;
  bool go_round(const Contact& contact, const Vec3& tangent, double angle) noexcept;
  bool advance(const Vec3& motion) noexcept;
  void meet(const Face& face) noexcept;
  bool can_meet(const Face& face) const noexcept;

  double rest_;
  double local_reach_;
  std::vector<Material> materials_;  // by object
  bool frictionless_ = true;
  Rules rules_;
  State state_;
  std::vector<Face> faces_;
  std::vector<Box> boxes_;            // of faces_
  std::vector<std::uint32_t> local_;  // faces_ in a cube, in order
  Vec3 local_centre_ = Vec3::Zero();
  bool has_local_ = false;
  std::vector<Contact> contacts_before_;
  std::vector<Contact> vertex_contacts_;
  std::vector<Stay> stays_;
  std::vector<Contact> near_;
  std::vector<Vec3> directions_;
  std::vector<HalfSpace> half_spaces_;
  Counters counters_;
};

}  // namespace hapton
