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

// A scene in parts, each with a proxy in its own frame O that never crosses the part's surface: the objects that stand still (part 0, if
// there are any), the objects of each motion, each body that can be carved. To feel: to compute a step. Arguments in frame S. RT: all.
class FeltParts {
 public:
  virtual ~FeltParts() = default;
  // X_SO of the part at this sample; the other functions are given it.
  virtual Pose pose(std::size_t part) const noexcept = 0;
  // The part's proxy starts at p_S, in free space.
  virtual void reset(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept = 0;
  // The part goes on from exactly p_S, where its proxy was before this sample (ForceMethod::resume). False: p_S may be on the wrong side of
  // its surface (its shape has changed, or its proxy then is not known), and it goes on from where its proxy is.
  virtual bool resume(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept = 0;
  // is_correction: see MethodInput::is_correction. is_shared: other parts hold the proxy as well, or did in the last sample.
  struct Turn {
    bool is_correction = false;
    bool is_shared = false;
  };
  // The part's step with the device at p_S. Result in S, `object` an index into the scene's objects; where nothing touches, p_SP == p_S.
  virtual MethodOutput feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept = 0;
  // Whether any part may give way in this sample.
  virtual bool may_give_way() const noexcept { return false; }
  // Whether this part gives way: in this sample it is felt once, at the device point, and the other parts follow its proxy in place of the
  // device. settle: the position, p_S, that the other parts allow for that proxy.
  virtual bool gives_way(std::size_t /*part*/) const noexcept { return false; }
  virtual void settle(std::size_t /*part*/, const Vec3& /*p_S*/) noexcept {}
  // How often the part may be felt in a sample, at least once; after that the others follow its last proxy. Each resume() adds up to two
  // calls of feel() to that. Bounds the time of a part whose steps are slow.
  virtual int most_turns(std::size_t /*part*/) const noexcept { return std::numeric_limits<int>::max(); }
  // Of the part's objects.
  virtual StiffnessRange stiffness(std::size_t /*part*/) const noexcept { return {}; }
  // With Turn::is_shared none of the part's objects has friction, so it holds the proxy along its normal.
  virtual bool is_frictionless(std::size_t /*part*/) const noexcept { return false; }
  // Of that object, N s/m, if feel() leaves damping out with Turn::is_shared. 0: feel() includes it, or there is none.
  virtual double damping(std::size_t /*part*/, int /*object*/) const noexcept { return 0.0; }
};

// One proxy for all parts: the point nearest to the device that all of their surfaces allow, reached on a path that all of them allow.
//
// The share of a part is the vector from its proxy to the device point that it follows: the device, less the shares of the other parts.
// So all proxies are at the same place, the shares add up to device minus proxy, and each part's force is that of its share. A sample
// starts from the last shares, corrected for the new device point by a quadratic program over the planes that held the proxy.
// Then the parts follow in turn until none changes anything, or for a fixed number of rounds: Dykstra's alternating projections, which find
// the nearest point of several convex sets (Boyle & Dykstra 1986), each projection replaced by the part's step, friction included.
//
// In a sample in which a second part comes into contact, the first has followed the hand without it, maybe to where the second does not let
// it go, such as below a wall that stands on a floor. So both begin the sample again from where their proxies were, each with the other's
// share known. Between two parts without room for the proxy the shares would grow without end. So each share is at most about kMaxShare (8)
// times |device - proxy|, except that of the first part that holds the proxy, part 0 if it does: the proxy is never pressed into that part.
//
// Between parts of different stiffness all shares have the mean stiffness, weighted by the shares, as between objects of one method
// (ContactMaterial). So, but for damping, the force is at most the largest stiffness times |device - proxy|, at any angle of two parts.
//
// Where several parts hold the proxy, dynamic friction takes the place of static friction: a part that breaks away would slide, within its
// own step, farther than the others let it.
//
// Damping of parts that share the proxy is computed here, from the device's velocity relative to each part, along its share. A part that
// computed it in feel() would take changes of the other shares for motion of the device.
//
// A part that gives way (material that is being cut) is not a surface to project on: it moves its proxy a fraction of the way from its
// last position to the device. The proxy is the point nearest to that which the other parts allow, as if the material were a spring.
// Device minus proxy is then divided as between surfaces: the other parts get its component along the sum of their shares, the parts that
// give way get the rest.
//
// Each part is felt kLift outside the surfaces of the other parts that hold the proxy, so that a probe between two surfaces that just touch
// is on its own side of both.
// MovingMethod, SculptMethod and PatchChain (patch/patch_chain.h) feel their parts like this, and so give the same forces.
// Frame: S. RT: all but construction. Threads: one.
class CommonProxy {
 public:
  // 0x1p-24 of the scene's extent: 64 contact offsets, 6 nm in a scene of 100 mm.
  static constexpr double kLift = 0x1p-24;

  // max_parts: largest number of parts. extent_m: of the scene. in_series: for parts that cannot be felt twice in a sample. Each is then
  // felt once and follows the proxy of the part before it. All have one proxy only where one part is touched, or two at right angles.
  CommonProxy(std::size_t max_parts, double extent_m, bool in_series = false);
  // For another scene. Call reset, go_on_from or forget next.
  void set_extent(double extent_m) noexcept { lift_m_ = kLift * extent_m; }

  // The next step begins at p_S: it resets each part there.
  void reset(const Vec3& p_S) noexcept { reset_to_ = p_S; }
  // The proxy is at p_S, and so are those of the parts already: nothing holds it yet.
  void go_on_from(const Vec3& p_S) noexcept;
  // The parts have been replaced, or start again by themselves: nothing holds the proxy.
  void forget() noexcept;

  // Pre: count is the same as in the step before, or reset, go_on_from or forget was called since; at most as many as at construction.
  // has_still: part 0 stands still, or its surface is to be kept as exactly: if the parts do not agree within the rounds of a step, it is
  // felt last. dt_s: time since the step before; 0: no damping.
  MethodOutput step(FeltParts& felt, std::size_t count, bool has_still, const Vec3& p_SD, double dt_s = 0.0) noexcept;

  // In the last step there was no room for the proxy between two parts, see above.
  bool is_squeezed() const noexcept { return is_squeezed_; }
  // Of the last step: a part's force, N, and its share, m. Zero: it does not hold the proxy.
  Vec3 force_of(std::size_t part) const noexcept { return parts_[part].output.contact ? parts_[part].force_n : Vec3(Vec3::Zero()); }
  const Vec3& share_of(std::size_t part) const noexcept { return parts_[part].share; }

 private:
  struct Part {
    Pose X_SO = Pose::Identity();
    Pose X_before = Pose::Identity();    // X_SO in the sample before
    Vec3 share = Vec3::Zero();           // from its proxy to the device point that it followed; zero: it holds nothing
    Vec3 followed_point = Vec3::Zero();  // the device point that it followed last
    Vec3 p_SP = Vec3::Zero();            // its proxy
    Vec3 lift = Vec3::Zero();            // its proxy minus the common proxy (kLift)
    Vec3 p_before = Vec3::Zero();        // its proxy after the sample before, with the part at X_before
    Vec3 lift_before = Vec3::Zero();
    bool is_shared = false;        // it was felt as one of several that hold the proxy
    bool with_others = false;      // other parts held the proxy when it was felt last
    bool was_with_others = false;  // with_others, in the last sample
    bool is_felt = false;          // it was felt in this sample
    int turns = 0;                 // how often it was felt in this sample, less the calls in begin_again()
    bool was_held = false;         // it held the proxy before this sample
    bool is_limited = false;       // limit_share() shortened its share when it was felt last
    bool begins_again = false;     // it was resumed in this sample, and not visited since
    bool gives_way = false;        // FeltParts::gives_way, in this sample
    double stiffness = 0.0;        // of its force in this sample, N/m
    MethodOutput output = {};
    Vec3 force_n = Vec3::Zero();  // what it adds to the force of this sample, if it is in contact

    bool holds() const noexcept { return !gives_way && !share.isZero(0.0); }
    // Its proxy after the sample before, moved along with the part to its present pose.
    Vec3 start() const noexcept { return X_SO * (X_before.inverse(Eigen::Isometry) * p_before); }
  };

  void begin_sample(FeltParts& felt) noexcept;
  void follow(FeltParts& felt) noexcept;
  void follow_in_series(FeltParts& felt) noexcept;
  void feel_parts_giving_way(FeltParts& felt) noexcept;
  void share_with_parts_giving_way(const FeltParts& felt) noexcept;
  MethodOutput conclude(FeltParts& felt) noexcept;
  void begin_round() noexcept;
  bool visit(FeltParts& felt, std::size_t i) noexcept;
  void limit_share(Part& part, double whole_m) noexcept;
  double limit_m(double whole_m) const noexcept;
  bool allows_more_rounds(const FeltParts& felt) const noexcept;
  std::size_t first_holding() const noexcept;
  void note_share(std::size_t i) noexcept;
  Vec3 lift_of(std::size_t i) const noexcept;
  void share_out() noexcept;
  bool has_second_contact() const noexcept;
  void begin_again(FeltParts& felt) noexcept;
  double find_mean_stiffness(const FeltParts& felt) noexcept;
  Vec3 velocity_relative_to(const Part& part) const noexcept;
  Vec3 force_with(const Part& part, double stiffness, double damping) const noexcept;
  MethodOutput sum(const FeltParts& felt) noexcept;

  std::vector<Part> parts_;
  std::vector<ContactPlane> planes_;
  std::vector<std::size_t> part_of_plane_;  // the part of each plane
  std::vector<std::size_t> with_share_;  // the first with_share_count_ of these: all parts that may have a share in this round, ascending
  std::size_t with_share_count_ = 0;
  std::size_t count_ = 0;
  bool has_still_ = false;
  bool in_series_;
  double lift_m_;
  Vec3 p_SD_ = Vec3::Zero();
  Vec3 goal_ = Vec3::Zero();         // what the proxy follows: the device point, or the proxy of what gives way
  bool is_goal_displaced_ = false;   // goal_ is the proxy of a part that gives way
  std::optional<Vec3> p_SD_before_;  // the device in the sample before
  double dt_s_ = 0.0;
  bool has_sample_ = false;            // there was a step
  int holding_count_ = 0;              // parts that hold the proxy
  bool is_shared_ = false;             // at the beginning of this round: several hold it, or one does while another gives way
  double longest_share_m_ = 0.0;       // length of the longest share at the beginning of the round
  Vec3 p_SP_ = Vec3::Zero();           // the common proxy
  bool is_squeezed_ = false;           // a share is limited
  std::optional<Vec3> reset_to_;       // reset() was called
  std::optional<Vec3> continue_from_;  // go_on_from() was called
};

}  // namespace hapton
