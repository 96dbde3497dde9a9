#pragma once

#include <array>
#include <optional>

#include "core/force/contact_qp.h"
#include "core/force/proxy/proxy_state.h"
#include "core/force/proxy/straight_sweep.h"
#include "core/force/step_work.h"

namespace hapton {

// Moves a proxy by continuous collision detection, over any triangles: one straight motion after another, each as far as nothing blocks it,
// to the constrained local minimum of the distance to the device (Zilles & Salisbury 1995, Ruspini et al. 1997). It replaces the followers
// in steps whose events cannot be told apart, and does not know where the device was in between.
//
// Distances decide, never signs of volumes: the proxy's distance to every triangle stays above clearance.offset - clearance.slop on its
// whole path, so edges, vertices and cracks narrower than that are as tight as faces, and both sides of a sheet are equal.
//
// A sphere that is put where it has no room, as into a slit narrower than itself, is as large as the room there: at the least distance from
// all surfaces, it is in contact with them. It grows to half of the room, and to its own size as soon as that fits. Growing never pushes
// it.
//
// A sphere that is put where it overlaps more triangles than it has contacts goes on like one that overlaps a few: a triangle that stops it
// at once takes the place of a contact that does not hold it, so that after a few motions the contacts are those that decide. Whether there
// is a direction that ends all overlaps, they show as well.
//
// Frame: TouchGeometry's local one. RT: yes; at most kMaxMotions motions in a call, and hardly more work than it is given: among many
// triangles a motion is interrupted, and the next call goes on with it. Keeps references.
class SweptMotion {
 public:
  // Most calls need a few; this bounds the time where rounding keeps it moving (decision 121).
  static constexpr int kMaxMotions = 256;

  // Since construction.
  struct Counters {
    std::uint64_t motions = 0;      // constrained motions solved
    std::uint64_t sweeps = 0;       // continuous collision queries
    std::uint64_t tests = 0;        // triangle against moving sphere
    std::uint64_t unconverged = 0;  // calls that ran out of motions or work: the proxy is valid but short of the minimum
  };

  SweptMotion(const ProxySurfaces& surfaces, const Clearance& clearance, bool is_point)
      : surfaces_(surfaces), clearance_(clearance), keep_(clearance), is_point_(is_point), sweep_(surfaces, is_point) {}

  // False: out of motions, or of that many units of work (step_work.h).
  // Pre: the proxy is at least clearance.offset - clearance.slop from each triangle that it can touch, or was put where it is.
  bool descend(ProxyState& proxy, const Vec3& device, int most_work = StepWork::kMax) noexcept;
  int work() const { return work_; }  // units, of the last call

  // Whether the probe is smaller than it should be, or in the middle of a motion. Then nothing else may move it, except to a new place:
  // forget().
  bool must_go_on() const { return is_shrunk() || sweep_.is_interrupted(); }
  bool is_shrunk() const { return keep_.offset < clearance_.offset; }
  // The next call, until it has settled, keeps a point only that far from surfaces: in a slit that something else has put it into. With the
  // clearance of sweeps the slit would push it out, in a narrow wedge far away.
  void keep_only(double offset) noexcept;
  void forget() noexcept {
    keep_ = clearance_;
    has_settled_ = true;
    drop_motion();
  }
  // The triangles have changed: a motion begins anew.
  void drop_motion() noexcept {
    sweep_.drop();
    has_looked_ = false;
  }

  const Counters& counters() const { return counters_; }

 private:
  static constexpr int kMaxIdle = 6;       // motions that lead no nearer
  static constexpr int kWorkOfMotion = 5;  // units, beside the triangles that it queries

  bool settle(ProxyState& proxy, const Vec3& device) noexcept;
  // Both: whether the call has settled; none: settle() goes on.
  std::optional<bool> finish_interrupted(ProxyState& proxy, const Vec3& device) noexcept;
  std::optional<bool> end_at_minimum(ProxyState& proxy, ConstrainedMotion& held, bool& has_forgotten) noexcept;
  bool is_blind(const ProxyState& proxy) const noexcept;
  void forget_progress() noexcept;
  void note_progress(double distance) noexcept;
  void fix_active(ProxyState& proxy, ConstrainedMotion& held, const Vec3& goal) noexcept;
  bool cross_empty_space(ProxyState& proxy, const Vec3& device) const noexcept;
  bool is_too_near(const ProxyState& proxy) const noexcept;
  ConstrainedMotion next_motion(const ProxyState& proxy, const Vec3& goal) noexcept;
  double find_room(const Vec3& p, bool& is_certain) noexcept;
  bool shrink_to_room(const Vec3& p) noexcept;
  void grow_to_room(const Vec3& p) noexcept;
  Vec3 rolled(const ProxyState& proxy, const ConstrainedMotion& held, const Vec3& device) const noexcept;
  Vec3 apply_friction(ProxyState& proxy, const Vec3& goal, const ConstrainedMotion& constrained) const noexcept;
  Material material_of(const ProxyState& proxy, const ConstrainedMotion& held) const noexcept;
  bool forget_doubtful(ProxyState& proxy, const ConstrainedMotion& held) const noexcept;
  static void bring_active_first(ProxyState& proxy, ConstrainedMotion& held) noexcept;
  using End = StraightSweep::End;
  End advance(ProxyState& proxy, const Vec3& motion) noexcept;
  End go_on(ProxyState& proxy) noexcept;
  void update_contacts(ProxyState& proxy, const Vec3& blocked_motion) const noexcept;

  const ProxySurfaces& surfaces_;
  Clearance clearance_;
  Clearance keep_;  // of the probe as large as it is
  bool is_point_;
  std::array<ContactPlane, ProxyState::kMaxContacts> planes_;
  int fixed_ = 0;  // contacts that hold the motion: the first ones, if all are used
  StraightSweep sweep_;
  Vec3 device_ = Vec3::Zero();  // of the last call, like the next
  bool has_settled_ = true;
  bool has_looked_ = false;  // for all that it overlaps at this position
  double nearest_ = 0.0;     // least distance from the device
  double pushed_ = 0.0;      // by the contacts, at this position
  int idle_ = 0;             // motions that led no nearer
  int work_ = 0;
  int most_work_ = 0;
  Counters counters_;
};

}  // namespace hapton
