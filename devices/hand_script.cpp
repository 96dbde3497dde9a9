#include "devices/hand_script.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr double kStepS = 1e-9 * static_cast<double>(HandScript::kStepNs);
constexpr double kFeelS = 0.02;   // time constant of the filter on the felt force and normal
constexpr double kTouchN = 0.15;  // a felt force above this is a contact
constexpr double kLostN = 0.03;   // below this for kLostS: contact lost
constexpr double kLostS = 0.25;
// Speeds in m/s and lengths of a calm hand, chosen by us: the script has to find and touch any scene; it need not imitate a person.
constexpr double kTravelSpeed = 0.25;
constexpr double kApproachSpeed = 0.10;
constexpr double kStrikeSpeed = 0.25;
constexpr double kLiftM = 0.006;        // between taps
constexpr double kStrikeDepthM = 0.02;  // a strike that meets nothing down to this depth below the last contact has missed
constexpr double kGripGain = 0.02;      // m/s of intention per N of missing force; slow against the hand's own 6 Hz
constexpr double kMaxPullM = 0.015;     // in contact the intention stays this near to the device
constexpr double kLeadSpeed = 0.6;      // of a led hand, which must not jump when the mouse pointer jumps

}  // namespace

HandScript::HandScript(const Options& options) : options_(options), random_(options.seed), hand_m_(options.start_m) {
  for (const TrajectoryRow& row : options_.path)
    has_orientations_ = has_orientations_ || row.has_turn || row.q_WT.coeffs() != Quat::Identity().coeffs();
  enter(first_phase());
}

// Uses the generator's bits, not a std distribution, so that the numbers are the same with every standard library.
double HandScript::uniform(double low, double high) noexcept { return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53; }

void HandScript::lead(const std::optional<Vec3>& p_WH) noexcept {
  if (p_WH && !p_WH->allFinite()) return;
  if (p_WH) {
    phase_ = Phase::led;
    lead_m_ = within_workspace(*p_WH);
  } else if (lead_m_) {
    lead_m_.reset();
    enter(options_.path.empty() ? Phase::leave : Phase::path);
  }
}

void HandScript::aim(std::span<const Vec3> p_WA) noexcept {
  std::array<Vec3, kMaxAims> aims_within;
  std::size_t count = 0;
  for (const Vec3& p : p_WA) {
    const bool is_within =
        p.allFinite() && (p - options_.workspace_min_m).minCoeff() >= 0.0 && (options_.workspace_max_m - p).minCoeff() >= 0.0;
    if (is_within && count < aims_within.size()) aims_within[count++] = p;
  }
  if (count == aim_count_ && std::equal(aims_within.begin(), aims_within.begin() + count, aims_m_.begin())) return;
  aims_m_ = aims_within;
  aim_count_ = count;
  // The hand is on its way to an old aim, at which there may be nothing now.
  if (phase_ == Phase::travel || phase_ == Phase::approach) enter(Phase::travel);
}

void HandScript::feel(const Vec3& p_WD, const Vec3& force_n) noexcept {
  filtered_force_n_ += (force_n - filtered_force_n_) * (kStepS / kFeelS);
  const double force = filtered_force_n_.norm();
  if (force > kTouchN) {
    normal_ = filtered_force_n_ / force;
    contact_m_ = p_WD;
  }
  contact_lost_s_ = force < kLostN ? contact_lost_s_ + kStepS : 0.0;
}

// Aims in front of one of the given surface points; without any, in front of a point of the front plane, at most search_share_ off its
// middle.
void HandScript::choose_aim() noexcept {
  const Vec3 middle = 0.5 * (options_.workspace_min_m + options_.workspace_max_m);
  const Vec3 half = 0.5 * (options_.workspace_max_m - options_.workspace_min_m);
  const double front = middle.z() + 0.9 * half.z();
  if (aim_count_ > 0) {
    const Vec3& at = aims_m_[static_cast<std::size_t>(uniform(0.0, static_cast<double>(aim_count_)))];
    aim_m_ = Vec3(at.x(), at.y(), std::max(front, at.z()));
    return;
  }
  const double radius = search_share_ * std::sqrt(uniform(0.0, 1.0));
  const double angle = uniform(0.0, 2.0 * std::numbers::pi);
  aim_m_ = middle + half.cwiseProduct(Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.9));
}

Vec3 HandScript::within_workspace(const Vec3& p_W) const noexcept {
  return p_W.cwiseMax(options_.workspace_min_m).cwiseMin(options_.workspace_max_m);
}

void HandScript::enter(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0.0;
  switch (phase) {
    case Phase::travel:
      choose_aim();
      break;
    case Phase::approach:
    case Phase::led:
      break;
    case Phase::press:
      press_n_ = uniform(0.8, 2.5);
      phase_end_s_ = uniform(0.4, 0.9);
      break;
    case Phase::slide:
      tangent_ = Vec3(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0));
      slide_m_per_s_ = uniform(0.04, 0.10);
      phase_end_s_ = uniform(0.6, 1.2);
      break;
    case Phase::tap:
      taps_left_ = static_cast<int>(uniform(3.0, 6.0));
      is_striking_ = false;
      aim_m_ = within_workspace(contact_m_ + kLiftM * normal_);
      phase_end_s_ = 4.0;  // surfaces may touch the probe on all sides, so that no lift ends the contact
      break;
    case Phase::circle: {
      const double radius_m = uniform(0.004, 0.012);
      slide_m_per_s_ = uniform(0.03, 0.08);
      turn_rad_per_s_ = slide_m_per_s_ / radius_m;
      phase_end_s_ = 2.0 * std::numbers::pi / turn_rad_per_s_ * uniform(1.0, 2.0);
      break;
    }
    case Phase::leave:
      aim_m_ = within_workspace(hand_m_ + 0.03 * normal_);  // a goal outside the workspace is never reached
      break;
    case Phase::path:
      path_s_ = -1.0;
      path_row_ = 0;
      break;
  }
}

bool HandScript::move_towards(const Vec3& goal, double speed_m_per_s) noexcept {
  const Vec3 motion = goal - hand_m_;
  const double distance_m = motion.norm();
  const double step_m = speed_m_per_s * kStepS;
  if (distance_m <= step_m) {
    hand_m_ = goal;
    return true;
  }
  hand_m_ += motion * (step_m / distance_m);
  return false;
}

// The point of the path at path_s_, the time after its first row. Pre: that time has not decreased, except to zero.
Vec3 HandScript::point_of_path() noexcept {
  const std::vector<TrajectoryRow>& rows = options_.path;
  const double t_s = rows.front().t_s + path_s_;
  while (path_row_ + 1 < rows.size() && rows[path_row_ + 1].t_s <= t_s) ++path_row_;
  const TrajectoryRow& from = rows[path_row_];
  if (path_row_ + 1 == rows.size()) return from.p_WD;
  const TrajectoryRow& to = rows[path_row_ + 1];
  return from.p_WD + (to.p_WD - from.p_WD) * ((t_s - from.t_s) / (to.t_s - from.t_s));
}

// The rotation of the path at path_s_, interpolated between the last row that was reached and the next one.
Quat HandScript::turn_of_path() const noexcept {
  const std::vector<TrajectoryRow>& rows = options_.path;
  const TrajectoryRow& from = rows[path_row_];
  if (path_row_ + 1 == rows.size()) return from.q_WT;
  const TrajectoryRow& to = rows[path_row_ + 1];
  const double share = (rows.front().t_s + path_s_ - from.t_s) / (to.t_s - from.t_s);
  return from.q_WT.slerp(std::clamp(share, 0.0, 1.0), to.q_WT);
}

void HandScript::follow_path() noexcept {
  if (path_s_ < 0.0) {
    if (move_towards(within_workspace(options_.path.front().p_WD), kTravelSpeed)) path_s_ = 0.0;
    return;
  }
  path_s_ += kStepS;
  const double length_s = options_.path.back().t_s - options_.path.front().t_s;
  if (options_.repeat_path && path_s_ > length_s) {
    path_s_ = 0.0;
    path_row_ = 0;
  }
  move_towards(within_workspace(point_of_path()), kMaxPathSpeed);
}

void HandScript::turn_tangent(double angle_rad) noexcept {
  const Vec3 middle = 0.5 * (options_.workspace_min_m + options_.workspace_max_m);
  const Vec3 half = 0.5 * (options_.workspace_max_m - options_.workspace_min_m);
  const Vec3 out = (hand_m_ - middle).cwiseQuotient(half);
  tangent_ = Eigen::AngleAxisd(angle_rad, normal_) * tangent_;
  // Near the end of the workspace the hand turns back.
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(out[axis]) > 0.85 && out[axis] * tangent_[axis] > 0.0) tangent_[axis] = -tangent_[axis];
  }
  tangent_ -= normal_ * normal_.dot(tangent_);
  const double length = tangent_.norm();
  tangent_ = length > 1e-3 ? Vec3(tangent_ / length) : normal_.unitOrthogonal();
}

// Slides along the surface (in Phase::press: stays) and keeps the force at press_n_.
void HandScript::follow_surface(const Vec3& p_WD, double turn_rad_per_s) noexcept {
  turn_tangent(turn_rad_per_s * kStepS);
  const double speed = phase_ == Phase::press ? 0.0 : slide_m_per_s_;
  hand_m_ += kStepS * (speed * tangent_ + kGripGain * (filtered_force_n_.norm() - press_n_) * normal_);
  const Vec3 pull = hand_m_ - p_WD;
  const double pull_m = pull.norm();
  if (pull_m > kMaxPullM) hand_m_ = p_WD + pull * (kMaxPullM / pull_m);
}

void HandScript::tap(const Vec3& p_WD) noexcept {
  if (!is_striking_) {
    if (move_towards(aim_m_, kStrikeSpeed) && filtered_force_n_.norm() < kLostN) is_striking_ = true;
    return;
  }
  const bool is_at_end = move_towards(within_workspace(aim_m_ - (kLiftM + kStrikeDepthM) * normal_), kStrikeSpeed);
  if (filtered_force_n_.norm() > kTouchN) {
    aim_m_ = within_workspace(p_WD + kLiftM * normal_);
    is_striking_ = false;
    --taps_left_;
  } else if (is_at_end) {
    taps_left_ = 0;
  }
}

void HandScript::advance_phase(const Vec3& p_WD) noexcept {
  const bool is_touching = filtered_force_n_.norm() > kTouchN;
  const bool is_phase_over = phase_s_ >= phase_end_s_;
  switch (phase_) {
    case Phase::travel:
      if (is_touching) return enter(Phase::press);
      if (move_towards(aim_m_, kTravelSpeed)) enter(Phase::approach);
      return;
    case Phase::approach: {
      if (is_touching) return enter(Phase::press);
      const Vec3 end(aim_m_.x(), aim_m_.y(), options_.workspace_min_m.z());
      if (!move_towards(end, kApproachSpeed)) return;
      // The approach met nothing: searches nearer to the middle, and after the smallest radius everywhere.
      search_share_ = search_share_ < 0.05 ? 0.9 : 0.5 * search_share_;
      normal_ = Vec3::UnitZ();
      return enter(Phase::leave);
    }
    case Phase::press:
      follow_surface(p_WD, 0.0);
      if (contact_lost_s_ > kLostS) return enter(Phase::leave);
      if (is_phase_over) enter(Phase::slide);
      return;
    case Phase::slide:
      follow_surface(p_WD, 0.0);
      if (contact_lost_s_ > kLostS) return enter(Phase::leave);
      if (is_phase_over) enter(Phase::tap);
      return;
    case Phase::tap:
      tap(p_WD);
      if (taps_left_ <= 0 || is_phase_over) enter(Phase::circle);
      return;
    case Phase::circle:
      follow_surface(p_WD, turn_rad_per_s_);
      if (contact_lost_s_ > kLostS || is_phase_over) enter(Phase::leave);
      return;
    case Phase::leave:
      if (move_towards(aim_m_, kTravelSpeed)) enter(Phase::travel);
      return;
    case Phase::led:
      move_towards(*lead_m_, kLeadSpeed);
      return;
    case Phase::path:
      follow_path();
      return;
  }
}

HandIntention HandScript::intention() noexcept {
  hand_m_ = within_workspace(hand_m_);
  // A slow tilt: amplitudes in rad, and frequencies in Hz without a short common period. Choices.
  const double turn = 2.0 * std::numbers::pi * tilt_time_s_;
  HandIntention next{hand_m_, Vec3(0.35 * std::sin(0.23 * turn), 0.25 * std::sin(0.31 * turn), 0.6 * std::sin(0.17 * turn))};
  if (phase_ == Phase::path && has_orientations_) next.q_WT = turn_of_path();
  if (phase_ == Phase::path && path_s_ >= 0.0) next.buttons = options_.path[path_row_].buttons;
  return next;
}

HandIntention HandScript::step(const Vec3& p_WD, const Vec3& force_n) noexcept {
  phase_s_ += kStepS;
  if (phase_ != Phase::led) tilt_time_s_ += kStepS;
  feel(p_WD, force_n);
  advance_phase(p_WD);
  return intention();
}

}  // namespace hapton
