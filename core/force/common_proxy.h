#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/force/contact_qp.h"
#include "core/force/force_method.h"
#include "core/math/types.h"

namespace hapton {

// The least and the largest stiffness of several objects, N/m.
struct StiffnessRange {
  double least = 0.0;
  double most = std::numeric_limits<double>::infinity();
};

// The parts of a scene that each feel it in a frame of their own: what stands still, which is part 0 if there is any, and each motion.
// All of them have a proxy that never crosses their surface. Frame of the arguments: S. RT: all.
class FeltParts {
 public:
  virtual ~FeltParts() = default;
  // X_SO at this sample; the others get it.
  virtual Pose pose(std::size_t part) const noexcept = 0;
  // It starts there, in free space.
  virtual void reset(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept = 0;
  // It goes on from exactly there, as ForceMethod::resume has it. False: its shape has changed since its proxy was there, and it goes on
  // from where it is.
  virtual bool resume(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept = 0;
  // is_correction: as MethodInput has it. is_shared: other parts hold the proxy as well.
  struct Turn {
    bool is_correction = false;
    bool is_shared = false;
  };
  // Its step with the device point there. The result in S, with the scene's number of the object; p_SP is p_S itself where nothing touches.
  virtual MethodOutput feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept = 0;
  // A part may give way in this sample.
  virtual bool may_give_way() const noexcept { return false; }
  // It gives way: in this sample it is felt once, at the device point, and the other parts follow its proxy in place of the device. settle:
  // where they let that proxy be.
  virtual bool gives_way(std::size_t /*part*/) const noexcept { return false; }
  virtual void settle(std::size_t /*part*/, const Vec3& /*p_S*/) noexcept {}
  // How often it may be felt in a sample, at least once; after that the others follow its last proxy. A bound for a part whose steps cost
  // much.
  virtual int most_turns(std::size_t /*part*/) const noexcept { return std::numeric_limits<int>::max(); }
  // Of its objects.
  virtual StiffnessRange stiffness(std::size_t /*part*/) const noexcept { return {}; }
  // Where it is felt as shared, none of its objects has friction: it holds the proxy along its normal.
  virtual bool is_frictionless(std::size_t /*part*/) const noexcept { return false; }
  // Of that object, N s/m, if feel() leaves the damping out where the proxy is shared. 0: it does not.
  virtual double damping(std::size_t /*part*/, int /*object*/) const noexcept { return 0.0; }
};

// One proxy for all parts: the point nearest to the device that all of their surfaces allow, reached on a path that all of them allow.
//
// The force on the proxy is the sum of what each part holds it with. A part follows the device less what the others hold, so each of them
// has its proxy at the same place, and the force of each is its own share. In each sample the shares of the last one are the first guess,
// carried on to the new device point by a quadratic program over the planes that held the proxy. Then the parts follow in turn until none
// of them changes anything: Dykstra's alternating projections, which converge to the nearest point of several convex sets (Boyle & Dykstra
// 1986), with the surface of each part, friction included, in place of a projection.
//
// In a sample in which a second part comes into contact, the first has followed the hand without it, maybe to where the second does not let
// it go, such as below a wall that stands on a floor. So both begin the sample again from where their proxies were, and know what the other
// one holds. Where there is no room between two parts, their shares would grow without end. So no share is longer than kMaxShare times
// the whole but that of the first part that holds the proxy, which is never pressed into that one: what stands still, if it does.
//
// Between parts of different stiffness all shares have the mean stiffness, weighted by the shares, as between objects of one method
// (ContactMaterial). So the force is no larger than the stiffness of the stiffest allows, however acute the angle between two of them.
//
// Where several parts hold the proxy, static friction is dynamic friction: a part that breaks away would slide farther than the others let
// it, within its own step.
//
// Damping is that of the device's own motion against each part, along what the part holds. A part by itself would see changes of what the
// others hold as motion of the device.
//
// A part that gives way (material that is being cut) is not a surface to project on: from where it was, it moves the proxy by a
// share of the distance to the device. The nearest point to that which the other parts allow is what a spring in place of the material
// would give. What holds the proxy against the device is then each part's share as if it were a surface: of the others, the extension along
// what they hold.
//
// A part is felt kLift above what else holds the proxy, so that a probe between two surfaces that just touch is on its own side of both.
//
// MovingMethod, SculptMethod and PatchChain (patch/patch_chain.h) feel their parts like this, and so give the same forces. Frame: S. RT:
// all but construction. Threads: one.
class CommonProxy {
 public:
  // 0x1p-24 of the scene's extent: 64 contact offsets, 6 nm in a scene of 100 mm.
  static constexpr double kLift = 0x1p-24;

  // most: parts. extent_m: of the scene. in_series: for parts that cannot feel a sample twice. Each then feels it once, and follows the
  // proxy of the part before it in place of the device. That is one proxy only where one part is touched, or two at right angles.
  CommonProxy(std::size_t most, double extent_m, bool in_series = false);
  // Another scene. Then reset, go_on_from or forget.
  void set_extent(double extent_m) noexcept { lift_m_ = kLift * extent_m; }

  // The next step begins there: each part is reset.
  void reset(const Vec3& p_S) noexcept { start_ = p_S; }
  // The proxy is known to be there, and the parts are: nothing holds it yet.
  void go_on_from(const Vec3& p_S) noexcept;
  // The parts are others, or begin anew by themselves: nothing holds the proxy.
  void forget() noexcept;

  // Pre: count is the same as in the step before, or reset, go_on_from or forget was called since; at most as many as at construction.
  // has_still: part 0 stands still, or is to be as exact: where the parts do not agree in time, it is felt last. dt_s: since the step
  // before; 0: there is no damping.
  MethodOutput step(FeltParts& felt, std::size_t count, bool has_still, const Vec3& p_SD, double dt_s = 0.0) noexcept;

  // There was no room in the last step, see above.
  bool is_squeezed() const noexcept { return is_squeezed_; }
  // Of the last step: the force of a part, and from its proxy to the device point that it followed. Zero: it holds nothing.
  Vec3 force_of(std::size_t part) const noexcept { return parts_[part].output.contact ? parts_[part].force_n : Vec3(Vec3::Zero()); }
  const Vec3& share_of(std::size_t part) const noexcept { return parts_[part].held; }

 private:
  struct Part {
    Pose X_SO = Pose::Identity();
    Pose X_before = Pose::Identity();  // X_SO in the sample before
    Vec3 held = Vec3::Zero();          // from its proxy to the device point that it followed; zero: it holds nothing
    Vec3 followed = Vec3::Zero();      // the device point that it followed last
    Vec3 p_SP = Vec3::Zero();          // its proxy
    Vec3 lift = Vec3::Zero();          // by which it follows above the common proxy
    Vec3 p_before = Vec3::Zero();      // its proxy after the sample before, as it was then
    Vec3 lift_before = Vec3::Zero();
    bool is_shared = false;        // it was felt as one of several that hold the proxy
    bool with_others = false;      // others did, when it was felt last
    bool was_with_others = false;  // in the last sample
    bool is_felt = false;          // in this sample
    int turns = 0;                 // how often it was, without new beginnings
    bool was_held = false;         // it held the proxy before this sample
    bool is_limited = false;       // its share, as it was felt last
    bool begins_again = false;     // it was resumed in this sample, and not felt since
    bool gives_way = false;        // in this sample
    double stiffness = 0.0;        // in this sample, N/m
    MethodOutput output = {};
    Vec3 force_n = Vec3::Zero();  // what it adds to the force of this sample, if it is in contact

    bool holds() const noexcept { return !gives_way && !held.isZero(0.0); }
    // Its proxy after the sample before, on the part where that is now.
    Vec3 start() const noexcept { return X_SO * (X_before.inverse(Eigen::Isometry) * p_before); }
  };

  void begin_sample(FeltParts& felt) noexcept;
  void follow(FeltParts& felt) noexcept;
  void follow_in_series(FeltParts& felt) noexcept;
  void lead(FeltParts& felt) noexcept;
  void share_with_giving(const FeltParts& felt) noexcept;
  MethodOutput conclude(FeltParts& felt) noexcept;
  void begin_round() noexcept;
  bool visit(FeltParts& felt, std::size_t i) noexcept;
  void limit_share(Part& part, double whole_m) noexcept;
  double limit_m(double whole_m) const noexcept;
  bool is_exact(const FeltParts& felt) const noexcept;
  std::size_t first_held() const noexcept;
  void note_held(std::size_t i) noexcept;
  Vec3 lift_of(std::size_t i) const noexcept;
  void share_out() noexcept;
  bool has_met_another() const noexcept;
  void begin_again(FeltParts& felt) noexcept;
  double find_mean_stiffness(const FeltParts& felt) noexcept;
  Vec3 velocity_past(const Part& part) const noexcept;
  Vec3 force_with(const Part& part, double stiffness, double damping) const noexcept;
  MethodOutput sum(const FeltParts& felt) noexcept;

  std::vector<Part> parts_;
  std::vector<ContactPlane> planes_;
  std::vector<std::size_t> plane_of_;  // the part of each plane
  std::vector<std::size_t> held_;      // the first held_count_: in their order, all parts that may have a share in this round
  std::size_t held_count_ = 0;
  std::size_t count_ = 0;
  bool has_still_ = false;
  bool in_series_;
  double lift_m_;
  Vec3 p_SD_ = Vec3::Zero();
  Vec3 goal_ = Vec3::Zero();         // what the proxy follows: the device point, or the proxy of what gives way
  bool is_led_ = false;              // it is the latter
  std::optional<Vec3> p_SD_before_;  // in the sample before
  double dt_s_ = 0.0;
  bool has_sample_ = false;     // there was a step
  int holding_ = 0;             // parts that hold the proxy
  bool is_shared_ = false;      // several do, at the beginning of this round
  double largest_m_ = 0.0;      // of the shares, at the beginning of the round
  Vec3 common_ = Vec3::Zero();  // the proxy
  bool is_squeezed_ = false;    // a share is limited
  std::optional<Vec3> start_;   // reset() was called
  std::optional<Vec3> place_;   // go_on_from() was called
};

}  // namespace hapton
