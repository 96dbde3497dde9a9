#pragma once

#include <array>
#include <span>

#include "core/force/sphere/offset_surface.h"

namespace hapton {

// Coefficients of Coulomb friction. dynamic_mu <= static_mu.
struct FrictionCoefficients {
  double static_mu = 0.0;
  double dynamic_mu = 0.0;
};

// The motion of a sphere's centre that the device drags over the offset surface under Coulomb friction, on one part or on the curve where
// two parts meet. The pull is device - centre: its tangential component w, which the contacts leave free, and its normal component of
// length d. With the coefficient mu, the centre follows the device so that |w| = mu d stays true. Let e be the unit vector along w, n that
// of the reaction of the contacts, and K the sum of multiplier times curvature along e. For a device velocity v the centre's velocity is
//
//   e (e + mu n) . v / (1 - (1 + mu^2) K).
//
// On a plane the solution is the tractrix, in closed form (SlidingPull). Around an edge or a vertex the equation is integrated by the
// method of Dormand & Prince (1980), with an error below 2^-36 per step. Along a curve |w| = mu d is one equation in one unknown: Newton's
// method. With the device held the centre follows w: in closed form on one part, by Newton's method along a curve.
//
// Frame and units: TouchGeometry's local ones. RT: yes. Pre: one or two contacts; they and their coefficients outlive this object.
class OffsetDrag {
 public:
  static constexpr double kMinPull = 0x1p-42;       // a shorter pull has no direction
  static constexpr double kMinStability = 0x1p-26;  // below it the centre moves too fast to follow
  static constexpr int kMaxSteps = 24;  // of one integration; a shallow drag needs short steps, and is followed in shorter pieces

  struct Pull {
    Vec3 tangential = Vec3::Zero();  // w
    double length = 0.0;             // |w|
    double depth = 0.0;              // d; negative if a single contact would have to pull
    Vec3 normal = Vec3::Zero();      // n
    Vec3 along = Vec3::Zero();       // two contacts only: unit, along the curve where they meet
    std::array<double, 3> multiplier{};
    FrictionCoefficients friction;  // of the contacts, their means weighted by the multipliers

    double excess() const { return length - friction.dynamic_mu * depth; }
  };

  OffsetDrag(std::span<const OffsetContact> contacts, std::span<const FrictionCoefficients> friction, double offset) noexcept
      : contacts_(contacts), friction_(friction), offset_(offset) {}

  // False where the contacts' normals are parallel.
  bool find_pull(const Vec3& c, const Vec3& device, Pull& pull) const noexcept;
  // The rate at which |w| - mu d rises while the centre stays in place. Where the pull has no direction, `motion` gives it.
  double find_excess_rate(const Pull& pull, const Vec3& motion) const noexcept;
  // The decrease of |w| - mu d for each unit of length that the centre moves along e; negative or zero: the equilibrium has vanished.
  double find_stability(const Pull& pull) const noexcept;
  // The centre's velocity for a device with the velocity `motion`.
  Vec3 find_rate(const Pull& pull, const Vec3& motion) const noexcept;

  // A position on the solution over curved parts, while the device moves straight. The solution has a parameter s for which centre and time
  // stay smooth even where the equilibrium on the cone vanishes, at a stability of zero. Around an edge or a vertex dt/ds = stability and
  // dc/ds = e (e + mu n) . v. Along a curve, s is the distance along the tangent at the start, divided by (e + mu n) . v at the start.
  struct Flow {
    Vec3 centre = Vec3::Zero();
    double time = 0.0;
    double step = 0.0;          // in s: the last step of the integration; 0: not known
    Vec3 slope = Vec3::Zero();  // dc/ds; output only
    double followed = 0.0;      // one contact: the part of `length` that was followed, also where flow() fails; output only
  };
  Vec3 find_slope(const Pull& pull, const Vec3& motion) const noexcept;                             // dc/ds
  bool flow(const Vec3& from, const Vec3& to, double length, Flow& at, int& tests) const noexcept;  // by `length` in s; false: not that far
  // On a face or on a curve: the centre while the device moves straight from `from` to `to`. `c`: in, the sliding centre at `from`; out, at
  // `to`. False: no solution is found over that distance; `c` is then undefined. `tests`, here and below: is raised by the units of work.
  bool follow(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept;
  // A position on the line that follows w with the device held. The line has a parameter s for which `slope`, the derivative of the centre
  // by s, has length 1 where the line begins.
  struct Descent {
    Vec3 centre = Vec3::Zero();
    Vec3 slope = Vec3::Zero();  // output only
  };
  // Moves down that line by `length` in s; around an edge or a vertex at most to w = 0. `along`: e at the start. False: no such place.
  bool descend(const Vec3& device, const Vec3& along, double length, Descent& at, int& tests) const noexcept;
  // Projects c onto the offset surfaces of all contacts. False: it is too far from them, or their normals are parallel.
  bool restore(Vec3& c) const noexcept;

  bool is_flat() const { return !contacts_[0].is_curved() && (contacts_.size() < 2 || !contacts_[1].is_curved()); }
  // One contact: the time in [0, 1] at which the device comes out of the offset surface on the side of the centre; infinite: it does not.
  double time_of_release(const Vec3& from, const Vec3& to, const Pull& pull) const noexcept;

 private:
  FrictionCoefficients mean(const Pull& pull) const noexcept;
  double find_stability(const Pull& pull, const Vec3& direction) const noexcept;  // where e is known
  Vec3 direction_of(const Pull& pull, const Vec3& motion) const noexcept;
  bool is_last_step(const Vec3& step) const noexcept;
  bool restore(Vec3& c, int& tests) const noexcept;
  bool move_along_curve(const Vec3& ahead, double length, Vec3& c, int& tests) const noexcept;
  void descend_around(const Vec3& device, double length, Descent& at) const noexcept;
  bool flow_on_curve(const Vec3& from, const Vec3& motion, double length, Flow& at, int& tests) const noexcept;
  bool follow_on_face(const Vec3& from, const Vec3& to, Vec3& c) const noexcept;
  bool follow_on_curve(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept;
  void return_to_flow(const Vec3& from, const Vec3& motion, Flow& at) const noexcept;
  template <class Rate>
  static double integrate(Eigen::Vector4d& at, double length, double& step, int& tests, Rate&& rate) noexcept;

  std::span<const OffsetContact> contacts_;
  std::span<const FrictionCoefficients> friction_;
  double offset_;
};

}  // namespace hapton
