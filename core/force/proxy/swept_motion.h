#pragma once

#include <array>
#include <optional>

#include "core/force/contact_qp.h"
#include "core/force/proxy/proxy_state.h"
#include "core/force/proxy/straight_sweep.h"
#include "core/force/step_work.h"

namespace hapton {

// Moves a proxy by continuous collision detection, over any triangles: by straight motions in succession, each up to where a triangle
// blocks it, to the constrained local minimum of the distance to the device (Zilles & Salisbury 1995, Ruspini et al. 1997). It replaces the
// followers in steps whose events cannot be told apart. It uses only the newest device position, not the device's path to it.
//
// Distances decide, never signs of volumes: on its whole path the proxy stays farther than clearance.offset - clearance.slop from every
// triangle that it can touch. So it passes no edge, vertex or crack narrower than that, and both sides of a sheet behave alike.
//
// A sphere that is put where it has no room, such as into a slit narrower than itself, shrinks: its radius becomes the least distance of
// its centre from all surfaces. At the beginning of a later call it grows to half of that distance, and to its full radius as soon as that
// fits. Growing never pushes it.
//
// A sphere that is put where it overlaps more triangles than ProxyState::kMaxContacts continues like one that overlaps a few: a triangle
// that stops it at once replaces a contact that does not hold it, so that after a few motions its contacts are the triangles that limit its
// motion. These also show whether any direction ends all overlaps.
//
// Frame and unit: TouchGeometry's local ones. RT: yes; at most kMaxMotions motions in a call, and little more work than most_work: among
// many triangles a motion is interrupted, and the next call continues it. Keeps a reference to the surfaces.
class SweptMotion {
 public:
  // Most calls need a few motions; this bounds the time where rounding keeps the proxy moving (decision 121).
  static constexpr int kMaxMotions = 256;

  // Since construction.
  struct Counters {
    std::uint64_t motions = 0;      // constrained motions solved
    std::uint64_t sweeps = 0;       // continuous collision queries
    std::uint64_t tests = 0;        // triangle against moving sphere
    std::uint64_t unconverged = 0;  // calls that ran out of motions or work: the proxy is valid but short of the minimum
  };

  SweptMotion(const ProxySurfaces& surfaces, const Clearance& clearance, bool is_point)
      : surfaces_(surfaces), clearance_(clearance), present_clearance_(clearance), is_point_(is_point), sweep_(surfaces, is_point) {}

  // Moves the proxy to its local minimum. False: it used up the motions, or most_work units of work (step_work.h), before that.
  // Pre: the proxy is at least clearance.offset - clearance.slop from each triangle that it can touch, or was put nearer (see above).
  bool descend(ProxyState& proxy, const Vec3& device, int most_work = StepWork::kMax) noexcept;
  int work() const { return work_; }  // units used by the last call

  // Whether the probe is smaller than its full size, or in the middle of a motion. Then only descend() may move the proxy, unless it is put
  // at a new place: then call forget().
  bool must_go_on() const { return is_shrunk() || sweep_.is_interrupted(); }
  bool is_shrunk() const { return present_clearance_.offset < clearance_.offset; }
  // For a point that something else has put into a slit: the next call, and those that continue a motion interrupted in it, keep it only
  // `offset` away from surfaces. The clearance of sweeps would push it out of the slit, in a narrow wedge far away.
  void keep_only(double offset) noexcept;
  void forget() noexcept {
    present_clearance_ = clearance_;
    has_settled_ = true;
    drop_motion();
  }
  // The triangles have changed: an interrupted motion is dropped, and the next call starts a new one.
  void drop_motion() noexcept {
    sweep_.drop();
    has_searched_overlaps_ = false;
  }

  const Counters& counters() const { return counters_; }

 private:
  static constexpr int kMaxIdleMotions = 6;  // motions in succession that come no nearer to the device
  static constexpr int kWorkOfMotion = 5;    // units of a motion, in addition to the triangles that it queries

  bool settle(ProxyState& proxy, const Vec3& device) noexcept;
  // Both return whether the call has settled; nothing: settle() goes on.
  std::optional<bool> finish_interrupted(ProxyState& proxy, const Vec3& device) noexcept;
  std::optional<bool> end_at_minimum(ProxyState& proxy, ConstrainedMotion& constrained, bool& has_forgotten) noexcept;
  bool may_overlap_more(const ProxyState& proxy) const noexcept;
  void forget_progress() noexcept;
  void note_progress(double distance) noexcept;
  void fix_active(ProxyState& proxy, ConstrainedMotion& constrained, const Vec3& goal) noexcept;
  bool cross_empty_space(ProxyState& proxy, const Vec3& device) const noexcept;
  bool is_too_near(const ProxyState& proxy) const noexcept;
  ConstrainedMotion next_motion(const ProxyState& proxy, const Vec3& goal) noexcept;
  double find_room(const Vec3& p, bool& is_certain) noexcept;
  bool shrink_to_room(const Vec3& p) noexcept;
  void grow_to_room(const Vec3& p) noexcept;
  Vec3 rolled(const ProxyState& proxy, const ConstrainedMotion& constrained, const Vec3& device) const noexcept;
  Vec3 apply_friction(ProxyState& proxy, const Vec3& goal, const ConstrainedMotion& constrained) const noexcept;
  Material material_of(const ProxyState& proxy, const ConstrainedMotion& constrained) const noexcept;
  bool forget_doubtful(ProxyState& proxy, const ConstrainedMotion& constrained) const noexcept;
  static void bring_active_first(ProxyState& proxy, ConstrainedMotion& constrained) noexcept;
  using End = StraightSweep::End;
  End advance(ProxyState& proxy, const Vec3& motion) noexcept;
  End go_on(ProxyState& proxy) noexcept;
  void update_contacts(ProxyState& proxy, const Vec3& blocked_motion) const noexcept;

  const ProxySurfaces& surfaces_;
  Clearance clearance_;
  Clearance present_clearance_;  // clearance for the probe's present size
  bool is_point_;
  std::array<ContactPlane, ProxyState::kMaxContacts> planes_;
  int fixed_count_ = 0;  // number of contacts, the first ones, that hold the motion; 0 unless all kMaxContacts are used
  StraightSweep sweep_;
  Vec3 device_ = Vec3::Zero();  // position in the last call; progress is counted anew when it changes
  bool has_settled_ = true;
  bool has_searched_overlaps_ = false;  // the last motion was zero, to find all triangles that the probe overlaps
  double least_distance_ = 0.0;         // least distance from the device so far
  double largest_deviation_ = 0.0;      // largest deviation of a motion from its goal by contacts, since the proxy last came nearer
  int idle_motions_ = 0;                // motions in succession that came no nearer
  int work_ = 0;
  int most_work_ = 0;
  Counters counters_;
};

}  // namespace hapton
