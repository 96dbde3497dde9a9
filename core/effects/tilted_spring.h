#pragma once

#include "core/effects/surface_bumps.h"

namespace hapton {

// The force of a surface whose height h changes from place to place, at the depth p below it: f(p) (n - grad h), with
// dp/dx = -(n - grad h). Its derivative with the opposite sign, which the hand feels as stiffness, is
//   K = k v v' + f grad grad h + s P,   v = n - grad h,  k = df/dp,  P the projection along the surface,
// s a spring of friction along the surface. Where bumps are short, the sideways term f grad grad h is by far the largest. On curved
// surfaces the touched place moves faster or slower than the hand; K is that of flat surfaces. Units: SI.
struct TiltedSpring {
  double spring_n_per_m = 0.0;    // k
  double slope_squared = 0.0;     // |grad h|^2
  double bending_n_per_m = 0.0;   // f times the largest curvature, not less than 0
  double sideways_n_per_m = 0.0;  // s

  // The largest eigenvalue of K, or more where gradient and largest curvature do not point the same way. RT: yes.
  double largest_n_per_m() const noexcept;
};

// The largest stiffness on bumps, wherever they are touched. pressed_n: the force f of the surface. The result is at least the largest
// eigenvalue of K, and for ridges at most a few percent more. Given damping in Ns/m in place of springs, it is in Ns/m. RT: yes.
double largest_on_bumps(const SurfaceBumps& bumps, double spring_n_per_m, double sideways_n_per_m, double pressed_n) noexcept;

}  // namespace hapton
