#pragma once

#include "core/force/proxy/surface_point.h"

namespace hapton {

// Coulomb friction of a surface point that follows the device from event to event. The pull w is the part of device - point that the
// surface leaves free (along the face or edge); the depth is |device - point - w|. The point is in one of three states:
//
//   stick   while |w| <= mu_s depth. When the pull exceeds that, the point moves along w, with the device held, until |w| = mu_d depth.
//   slide   keeps |w| = mu_d depth: on a face along a tractrix (SlidingPull), on a concave edge along a straight line.
//   stop    where the cone grows at least as fast as the pull, at a concave edge, or at a vertex. It slides on when |w| reaches mu_d depth
//           again, and sticks when |w| has fallen to FrictionMotion::kRestick of that.
//
// This is the limit of ever smaller sub-steps of return mapping for a device that moves straight. Source: Moreau (1977), the sweeping
// process; Hayward & Armstrong (2000) for the two coefficients.
//
// Frame: TouchGeometry's local one. RT: yes.
class SurfaceFriction {
 public:
  // Call when the point comes onto a surface of this material.
  void begin(const Material& material, bool slides) noexcept;

  bool acts() const { return static_mu_ > 0.0; }
  bool slides() const { return slides_; }  // the dynamic coefficient applies

  // Handles one event of the descent with the device held still; returns `again` while there is more to do.
  SurfaceNext descend(SurfacePoint& at, const Vec3& device) noexcept;
  // Finds the next event while the device moves from `from` to `to`, and sets `time` to it, never to less than before. Pre: settled.
  SurfaceNext follow(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;

 private:
  bool moves(double pull_length, double depth) const noexcept;
  SurfaceNext hold(double pull_length, double depth) noexcept;
  double begin_slide(double pull_length, double depth) noexcept;
  SurfaceNext descend_on_face(SurfacePoint& at, const Vec3& device) noexcept;
  SurfaceNext descend_on_edge(SurfacePoint& at, const Vec3& device) noexcept;
  SurfaceNext descend_at_vertex(SurfacePoint& at, const Vec3& device) noexcept;
  SurfaceNext stay(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;
  SurfaceNext slide_on_face(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;
  SurfaceNext slide_on_edge(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;

  double static_mu_ = 0.0;
  double dynamic_mu_ = 0.0;
  bool slides_ = false;  // the dynamic coefficient applies
  bool slips_ = false;   // the pull has just left the cone
  bool drags_ = false;   // the point is on its cone and follows a moving device
};

}  // namespace hapton
