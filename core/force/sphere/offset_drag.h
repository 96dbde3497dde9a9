#pragma once

#include <array>
#include <span>

#include "core/force/sphere/offset_surface.h"

namespace hapton {

// Coulomb friction's coefficients. sliding <= at_rest.
struct FrictionCoefficients {
  double at_rest = 0.0;
  double sliding = 0.0;
};

// A sphere's centre that slides over the offset surface under Coulomb friction, held by one part of it, or by two along the curve where
// they meet. With the pull w, the part of device - centre that the contacts leave free, the depth d of the rest, and the coefficient mu,
// the centre follows the device so that |w| = mu d stays. With the unit vectors e along w and n along the force of the contacts, and the
// surface's curvature along e (K: curvature times multiplier, summed up), its velocity is that of the device, v, times
//
//   (e + mu n) . v / (1 - (1 + mu^2) K)     along e.
//
// On a plane that is the tractrix, in closed form (SlidingPull). Round an edge or a vertex the differential equation is integrated by the
// method of Dormand & Prince (1980), its error held below 2^-42. Along a curve |w| = mu d is one equation of one unknown: Newton's method.
//
// Frame: that of the contacts. RT: yes. Pre: one or two contacts, which outlive it.
class OffsetDrag {
 public:
  static constexpr double kLeastLag = 0x1p-42;        // a shorter one has no direction
  static constexpr double kLeastStability = 0x1p-26;  // less, and the centre moves too fast to be followed

  struct Pull {
    Vec3 way = Vec3::Zero();     // what the contacts leave free of device - centre
    double length = 0.0;         // of it
    double depth = 0.0;          // of the rest; below zero where one contact would have to draw
    Vec3 normal = Vec3::Zero();  // unit, of the contacts' force
    Vec3 along = Vec3::Zero();   // of two contacts: unit, along their curve
    std::array<double, 3> multiplier{};
    FrictionCoefficients friction;  // the means, weighted by the multipliers

    double excess() const { return length - friction.sliding * depth; }
  };

  OffsetDrag(std::span<const OffsetContact> contacts, std::span<const FrictionCoefficients> friction, double offset) noexcept;

  // False where the contacts' normals are parallel.
  bool find_pull(const Vec3& c, const Vec3& device, Pull& pull) const noexcept;
  // How fast the device leaves the cone of a centre that stays. Where there is no lag, `motion` says which way.
  double find_drive(const Pull& pull, const Vec3& motion) const noexcept;
  // By how much |w| - mu d falls for each unit of the way.
  double find_stability(const Pull& pull) const noexcept;
  // The centre's velocity for the device's.
  Vec3 find_rate(const Pull& pull, const Vec3& motion) const noexcept;

  // How far it is, with the device on its straight way, on what is not flat. From one place to the next leads a parameter in which centre
  // and time are smooth even where the place on the cone ends, at a stability of zero: round an edge or a vertex dc = e (e + mu n) . v, dt
  // = stability; along a curve the place along the tangent at the start, in the same unit.
  struct Flow {
    Vec3 centre = Vec3::Zero();
    double time = 0.0;
    double step = 0.0;          // of the integration, that was good so far; 0: not known
    Vec3 slope = Vec3::Zero();  // of the centre, by that parameter; out only
  };
  Vec3 find_slope(const Pull& pull, const Vec3& motion) const noexcept;
  bool flow(const Vec3& from, const Vec3& to, double length, Flow& at, int& tests) const noexcept;
  // Elsewhere: the centre while the device goes straight between the two. `c`: in, its place before, which slides on; out, after. False: it
  // cannot be followed so far. `tests`: counts pieces of work.
  bool follow(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept;
  // The device held: down along w, by that length; of a curve: along the direction of w before, `way`.
  bool descend(const Vec3& device, const Vec3& way, double length, Vec3& c, int& tests) const noexcept;
  // Back to the offset from all contacts.
  bool restore(Vec3& c) const noexcept;

  bool is_flat() const { return !contacts_[0].is_curved() && (contacts_.size() < 2 || !contacts_[1].is_curved()); }
  // When a device comes out of a single contact, on the side of the centre: in [0, 1], or infinite.
  double time_of_release(const Vec3& from, const Vec3& to, const Pull& pull) const noexcept;

 private:
  FrictionCoefficients mean(const Pull& pull) const noexcept;
  double find_curving(const Pull& pull, const Vec3& way) const noexcept;
  Vec3 direction_of(const Pull& pull, const Vec3& motion) const noexcept;
  bool go_on_curve(const Vec3& ahead, double length, Vec3& c, int& tests) const noexcept;
  bool flow_on_curve(const Vec3& from, const Vec3& motion, double length, Flow& at, int& tests) const noexcept;
  bool follow_on_face(const Vec3& from, const Vec3& to, Vec3& c) const noexcept;
  bool follow_on_curve(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept;
  void return_to_flow(const Vec3& from, const Vec3& motion, Flow& at) const noexcept;
  template <class Rate>
  static bool integrate(Eigen::Vector4d& at, double length, double& step, int& tests, Rate&& rate) noexcept;

  std::span<const OffsetContact> contacts_;
  std::span<const FrictionCoefficients> friction_;
  double offset_;
};

}  // namespace hapton
