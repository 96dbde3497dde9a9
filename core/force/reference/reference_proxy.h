#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/force/reference/half_space_projection.h"
#include "core/force/touch_scene.h"
#include "core/geometry/closest_point.h"

namespace hapton {

// The proxy of the reference: its position, its contacts, and its motion to an equilibrium for one device position.
// All lengths in local units of the reference: the power of two that puts the scene's diagonal, or the probe's radius if larger, into [1/2,
// 1). The caller adds the triangles nearby. A point probe is a sphere of radius kPointRadius, so distances decide and never signs: it
// passes no edge, vertex or crack narrower than itself. RT: no heap, lock or system call after construction, but unbounded time.
class ReferenceProxy {
 public:
  static constexpr double kPointRadius = 0x1p-32;  // 2^16 times the error of a distance

  struct Face {
    PreparedTriangle shape;
    std::uint32_t triangle = 0;
    std::uint32_t object = 0;
  };
  struct Contact {
    Face face;
    ClosestPoint near;
  };
  // Everything that the proxy remembers.
  struct State {
    Vec3 position = Vec3::Zero();
    std::vector<Contact> contacts;
    Material material;  // mean of the active contacts, weighted by multipliers
    int object = -1;    // of the contact with the largest multiplier; -1: none yet
    bool free = true;
    bool sliding = false;
  };
  // Options of a motion besides the materials.
  struct Rules {
    bool friction = true;
    bool tips_at_boundaries = true;  // a proxy on the boundary of a face counts as on the edge
    // Where a local minimum ends, the proxy follows the steepest path over the surface to the next. False: it may fly straight over convex
    // edges to some other minimum; never with friction.
    bool keeps_to_surface = true;
    double near_enough = 0.0;  // local units: the motion ends as soon as the proxy is nearer to the device than this
  };
  struct Counters {
    std::uint64_t substeps = 0;      // with triangles nearby
    std::uint64_t motions = 0;       // straight pieces of the proxy's path
    std::uint64_t most_motions = 0;  // in one descent
    std::uint64_t unconverged = 0;   // descents stopped by the limit on motions: the proxy is valid but short of the minimum
    std::uint64_t escapes = 0;       // escapes (docs/glossary.md) of a point probe
    std::uint64_t infeasible = 0;    // projections without a solution, by rounding
  };

  // probe_radius in local units, zero for a point. most_faces: capacity of add_face().
  ReferenceProxy(double probe_radius, std::vector<Material> materials, std::size_t most_faces);

  // One for each object, as many as at construction.
  void set_materials(std::span<const Material> materials) noexcept {
    std::copy_n(materials.begin(), std::min(materials.size(), materials_.size()), materials_.begin());
    note_friction();
  }

  void clear_faces() noexcept;
  void add_face(const Face& face) noexcept;
  std::size_t faces() const { return faces_.size(); }

  // Forgets all contacts and moves the proxy to p, free.
  void place_free(const Vec3& p) noexcept;
  // Forgets all contacts and moves the proxy to p, not free.
  void place_held(const Vec3& p, bool sliding) noexcept;

  // As place_held, not sliding. A point probe that is nearer to faces than its radius, because positions far from the origin are rounded,
  // is moved out until it is that far from them, by at most its radius, if there is room. Pre: the faces near p have been added.
  void place_clear(const Vec3& p) noexcept;

  // Puts a point probe with friction onto the surface near p, in contact with the faces nearest to p. False: there is no such position, and
  // the proxy is left near p without contacts; or the probe is a sphere or without friction, and nothing changes. Pre: as above.
  bool place_on_surface(const Vec3& p, bool sliding) noexcept;
  // Whether a held proxy can be exactly at p: no face is nearer than its offset less a quarter of a point's radius. Pre: as above.
  bool has_room(const Vec3& p) noexcept;

  // Whether the position depends on the device's path, not only on the path's end: there is friction.
  bool has_memory() const { return !is_frictionless_; }
  void set_sliding(bool sliding) noexcept { state_.sliding = sliding; }

  // One sub-step: the device has moved straight from the first position to the second; moves the proxy to its equilibrium for the second.
  void follow(const Vec3& device_from, const Vec3& device_to, const Rules& rules) noexcept;

  const State& state() const { return state_; }
  // Copies without allocation. Pre: `to` was made by make_state().
  void save(State& to) const noexcept { to = state_; }
  void restore(const State& from) noexcept { state_ = from; }
  State make_state() const;

  // The proxy's position on the surface itself. A sphere: its position. A point: its position moved onto all active contacts, unless they
  // meet at too acute an angle; the device itself where the force would be attractive.
  Vec3 surface_position(const Vec3& device) noexcept;

  double rest_offset() const { return rest_offset_; }  // radius of the probe: distance of its centre from its contacts
  const Counters& counters() const { return counters_; }
  void clear_counters() { counters_ = {}; }

 private:
  struct Box {
    Vec3 low, high;
  };
  struct Pull {
    HalfSpaceProjection motion;  // from the proxy, as far as the contacts allow
    const Contact* strongest = nullptr;
  };

  // The part of a motion in which the proxy is over a face: shares of the motion at entry and exit.
  struct FaceInterval {
    double from, until;
  };
  struct FirstHit {
    double until = 1.0;  // share of the motion
    const Face* face = nullptr;
  };
  // The one or two triangles over which a sphere slips, and its distances from them.
  struct SlipParts {
    std::array<PreparedTriangle, 2> shape;
    std::array<double, 2> near_distance{};
    std::array<ClosestPoint, 2> near;  // of the last direction_at()
    std::size_t count = 0;

    Vec3 direction_at(const Vec3& p, const Vec3& device) noexcept;
    bool restore(Vec3& p) const noexcept;
  };

  // In local units. A distance within the scene is good to 2^-48.
  static constexpr double kTolerance = 0x1p-38;  // a 64th of a point's radius, far above rounding: contacts within it count
  static constexpr double kStill = 0x1p-46;      // shorter motions count as zero: four times the rounding error
  static constexpr double kFeasible = 0x1p-44;   // of the projection onto half-spaces: 16 times the rounding error
  static constexpr double kLongestMotion = 4.0;  // a few times the scene's size, so that a distant device does not cost significant digits
  static constexpr double kSamePlane = 1e-14;    // normals with a cosine above 1 - this are of one plane
  static constexpr double kMinRoll = 1e-10;      // rad; a shorter arc counts as zero
  // In rest offsets: a shorter piece of a slip is straight, and is not divided where the features that hold the sphere change.
  static constexpr double kShortestSlip = 0x1p-14;
  // Capacities, so that a step needs no heap.
  static constexpr std::size_t kMaxNear = 48;          // faces that collect_near() keeps
  static constexpr std::size_t kMaxDirections = 1536;  // above 1 + 4 * 48 of the pull, faces and edges, and 1,128 of pairs of faces

  // A face at a concave edge.
  struct EdgeFace {
    Vec3 normal = Vec3::Zero();
    Vec3 inward = Vec3::Zero();
  };
  enum class AtVertex : std::uint8_t { elsewhere, held, left };

  void list_local_faces() noexcept;
  bool is_local(const Vec3& p, double bound) const noexcept;
  void list_close_faces() noexcept;
  bool is_close(const Vec3& p) const noexcept;
  FirstHit find_first(const Vec3& motion) noexcept;
  template <class FaceAt>
  FirstHit find_first(const Vec3& motion, std::size_t count, const FaceAt& face_at) const noexcept;
  void drag(const Vec3& device_from, const Vec3& device_to) noexcept;
  void descend(const Vec3& device) noexcept;
  bool escape(const Vec3& device) noexcept;
  bool is_on_open_face() const noexcept;
  void collect_near(const Vec3& p, double within) noexcept;
  HalfSpaceProjection project_above_near(const Vec3& goal, double height) noexcept;
  bool lift(const Vec3& start, double height) noexcept;
  const std::vector<Vec3>& directions_out(const Vec3& start, const Vec3& pull, double within) noexcept;
  bool cross_free_space(const Vec3& device) noexcept;
  void update_contacts() noexcept;
  void forget_boundaries_of_faces() noexcept;
  void add_face_below() noexcept;
  Pull project_pull(const Vec3& pull) noexcept;
  double pressure_of(double depth) const noexcept;
  Material material_of(const Pull& pull) const noexcept;
  Vec3 limit_by_friction(const Pull& pull) noexcept;
  Vec3 cut_at_boundary(const Pull& pull, const Vec3& motion) noexcept;
  double share_on_feature(const Contact& contact, const Vec3& motion) noexcept;
  double share_on_plane(const Contact& contact, const Vec3& motion) noexcept;
  void note_friction() noexcept {
    is_frictionless_ = std::none_of(materials_.begin(), materials_.end(), [](const Material& one) { return one.friction_static > 0.0; });
  }
  bool is_sphere() const { return rest_offset_ > 16.0 * kPointRadius; }
  bool has_friction() const { return !is_frictionless_ && rules_.friction; }
  bool keeps_to_surface() const { return rules_.keeps_to_surface || has_friction(); }
  const Vec3* find_vertex(const Pull& pull) const noexcept;
  bool leave_vertex(const Vec3& device, const Pull& pull) noexcept;
  bool find_concave_edge(const Pull& pull, Vec3& on_edge, std::array<EdgeFace, 2>& sides) noexcept;
  bool is_held_at_edge(const Vec3& device, const Pull& pull) noexcept;
  AtVertex slip_from_vertex(const Vec3& device, const Pull& pull) noexcept;
  bool leave_along(const Vec3& vertex, const Vec3& descent, const Vec3& device) noexcept;
  bool exceeds_friction(double pull, double depth, const Material& material) noexcept;
  void list_faces_at(const Vec3& vertex) noexcept;
  Vec3 find_steepest(const Vec3& vertex, const Vec3& to_device) noexcept;
  bool roll(const Vec3& device, const Pull& pull) noexcept;
  bool slip(const Vec3& device, const Pull& pull, const Vec3& motion) noexcept;
  bool tip_over(const Vec3& device, const Pull& pull) noexcept;
  bool tip_over(const Vec3& device, const Contact& contact) noexcept;
  Vec3 pivot_of(const Contact& contact) const noexcept;
  bool go_round(const Contact& contact, const Vec3& tangent, double angle) noexcept;
  bool advance(const Vec3& motion) noexcept;
  void add_contact(const Face& face) noexcept;
  bool can_touch(const Face& face) const noexcept;

  double rest_offset_;
  double local_half_side_;
  std::vector<Material> materials_;  // by object
  bool is_frictionless_ = true;
  Rules rules_;
  State state_;
  std::vector<Face> faces_;
  std::vector<Box> boxes_;                  // of faces_
  std::vector<std::uint32_t> local_faces_;  // indices into faces_ of those that reach into a cube around local_centre_, ascending
  Vec3 local_centre_ = Vec3::Zero();
  bool has_local_faces_ = false;
  std::vector<std::uint32_t> close_faces_;  // those of local_faces_ that are close to the probe, around close_centre_
  Vec3 close_centre_ = Vec3::Zero();
  bool has_close_faces_ = false;
  int creeps_ = 0;                              // motions in succession that covered hardly any distance
  std::vector<std::uint32_t> faces_at_vertex_;  // indices into faces_ of those at vertex_, ascending
  Vec3 vertex_ = Vec3::Zero();
  bool has_vertex_ = false;
  std::vector<Contact> contacts_before_;
  std::vector<Contact> vertex_contacts_;
  std::vector<FaceInterval> intervals_;
  std::vector<Contact> near_contacts_;
  std::vector<Vec3> directions_;
  std::vector<HalfSpace> half_spaces_;
  Counters counters_;
};

}  // namespace hapton
