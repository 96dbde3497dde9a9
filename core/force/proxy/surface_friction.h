#pragma once

#include "core/force/proxy/surface_point.h"

namespace hapton {

// Coulomb friction for a point of a surface that follows the device, from event to event. With the pull w, the part of device - point that
// the surface leaves free, and the depth |device - point - w|:
//
//   it sticks   while |w| <= mu_s depth; the event is that it exceeds it. Then it moves along w, the device held, until |w| = mu_d depth,
//   it slides   with |w| = mu_d depth from there on: over a face on a tractrix (SlidingLag), along a concave edge on a straight line,
//   it stays    where the cone grows faster than the device draws it on, at a concave edge, at a vertex. It slides on when |w| is at
//               mu_d depth again, and sticks once |w| has fallen to half of that (FrictionMotion::kRest).
//
// That is the limit of ever smaller sub-steps of return mapping, the device moving straight. Source: Moreau (1977), the sweeping process;
// Hayward & Armstrong (2000) for the two coefficients.
//
// Frame: TouchGeometry's local one. RT: yes.
class SurfaceFriction {
 public:
  // The point has come to a surface of this material.
  void begin(const Material& material, bool slides) noexcept;

  bool acts() const { return static_ > 0.0; }
  bool slides() const { return slides_; }  // the dynamic coefficient is in force

  // One event of the descent with the device held; `again`: there is more to come.
  SurfaceNext descend(SurfacePoint& at, const Vec3& device) noexcept;
  // The next event while the device goes from `from` to `to`; it happens at `time`, not before its old value. Pre: the point has settled.
  SurfaceNext follow(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;

 private:
  bool moves(double way, double depth) const noexcept;
  SurfaceNext hold(double way, double depth) noexcept;
  double share_of_way(double way, double depth) noexcept;
  SurfaceNext descend_on_face(SurfacePoint& at, const Vec3& device) noexcept;
  SurfaceNext descend_on_edge(SurfacePoint& at, const Vec3& device) noexcept;
  SurfaceNext descend_at_vertex(SurfacePoint& at, const Vec3& device) noexcept;
  SurfaceNext stay(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;
  SurfaceNext slide_on_face(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;
  SurfaceNext slide_on_edge(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept;

  double static_ = 0.0;
  double dynamic_ = 0.0;
  bool slides_ = false;  // the dynamic coefficient is in force
  bool slips_ = false;   // the pull has just left the cone
  bool drags_ = false;   // and the point on its cone, where a moving device draws it on
};

}  // namespace hapton
