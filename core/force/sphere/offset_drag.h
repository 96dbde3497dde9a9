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

// A sphere's centre that the device drags over the offset surface under Coulomb friction, on one part of it, or on the curve where two
// parts meet. The pull is device - centre: its tangential component w, which the contacts leave free, and its normal component of length d.
// With the coefficient mu, the centre follows the device so that |w| = mu d stays true. Let e be the unit vector along w, n the one along
// the reaction of the contacts, and K the sum of multiplier times curvature along e. For a device with velocity v the centre's velocity is
//
//   e (e + mu n) . v / (1 - (1 + mu^2) K).
//
// On a plane the solution is the tractrix, in closed form (SlidingPull). Around an edge or a vertex the equation is integrated by the
// method of Dormand & Prince (1980), with an error below 2^-36 a step. Along a curve |w| = mu d is one equation in one unknown: Newton's
// method. With the device held the centre follows w, in closed form on every part.
//
// Frame: that of the contacts. RT: yes. Pre: one or two contacts, which outlive it.
class OffsetDrag {
 public:
  static constexpr double kMinPull = 0x1p-42;       // a shorter pull has no direction
  static constexpr double kMinStability = 0x1p-26;  // below it the centre moves too fast to follow
  static constexpr int kMaxSteps = 24;  // of one integration: a shallow drag needs short ones, and is followed in shorter pieces

  struct Pull {
    Vec3 tangential = Vec3::Zero();  // w
    double length = 0.0;             // |w|
    double depth = 0.0;              // d; negative if a single contact would have to pull
    Vec3 normal = Vec3::Zero();      // n
    Vec3 along = Vec3::Zero();       // of two contacts: unit, along their curve
    std::array<double, 3> multiplier{};
    FrictionCoefficients friction;  // means, weighted by the multipliers

    double excess() const { return length - friction.dynamic_mu * depth; }
  };

  OffsetDrag(std::span<const OffsetContact> contacts, std::span<const FrictionCoefficients> friction, double offset) noexcept
      : contacts_(contacts), friction_(friction), offset_(offset) {}

  // False where the contacts' normals are parallel.
  bool find_pull(const Vec3& c, const Vec3& device, Pull& pull) const noexcept;
  // How fast |w| - mu d rises for a centre that stays. Where the pull has no direction, `motion` gives it.
  double find_excess_rate(const Pull& pull, const Vec3& motion) const noexcept;
  // By how much |w| - mu d falls for each unit of length that the centre moves along e.
  double find_stability(const Pull& pull) const noexcept;
  // The centre's velocity for a device with the velocity `motion`.
  Vec3 find_rate(const Pull& pull, const Vec3& motion) const noexcept;

  // A position on the solution over curved parts, while the device moves straight. The solution is parametrized so that centre and time
  // stay smooth even where the equilibrium on the cone vanishes, at a stability of zero: around an edge or a vertex dc = e (e + mu n) . v
  // and dt = stability; along a curve, the position along the tangent at the start, in the same unit.
  struct Flow {
    Vec3 centre = Vec3::Zero();
    double time = 0.0;
    double step = 0.0;          // of the integration, as it was last; 0: not known
    Vec3 slope = Vec3::Zero();  // derivative of the centre by that parameter; output only
    double followed = 0.0;      // how much of the length, where it could not be followed to its end; output only
  };
  Vec3 find_slope(const Pull& pull, const Vec3& motion) const noexcept;
  bool flow(const Vec3& from, const Vec3& to, double length, Flow& at, int& tests) const noexcept;
  // On flat parts: the centre while the device moves straight between the two. `c`: in, the sliding centre before; out, after. False: the
  // solution is not found over that distance. `tests`: counts units of work.
  bool follow(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept;
  // A position on the line along w with the device held. The lines are parametrized so that `slope`, the derivative of the centre by that
  // parameter, has length 1 where they begin.
  struct Descent {
    Vec3 centre = Vec3::Zero();
    Vec3 slope = Vec3::Zero();  // output only
  };
  // Down along w, by `length` of that parameter; at most to where w is zero. `along`: the unit vector along w before.
  bool descend(const Vec3& device, const Vec3& along, double length, Descent& at, int& tests) const noexcept;
  // Projects onto the offset of all contacts.
  bool restore(Vec3& c) const noexcept;

  bool is_flat() const { return !contacts_[0].is_curved() && (contacts_.size() < 2 || !contacts_[1].is_curved()); }
  // When the device comes out of a single contact, on the side of the centre: in [0, 1], or infinite.
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
