#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "core/math/types.h"
#include "runtime/trajectory_csv.h"

namespace hapton {

// Where the hand wants the stylus to be at the end of this step of its script, and how the hand tilts the stylus.
struct HandIntention {
  Vec3 p_WH = Vec3::Zero();        // m, frame W
  Vec3 gimbal_rad = Vec3::Zero();  // yaw about y, pitch about x, roll about the stylus
  std::optional<Quat> q_WT = {};   // on a path that has orientations: in place of gimbal_rad
  std::uint32_t buttons = 0;       // buttons that the hand holds down; 0 unless a path has buttons
};

// The motion of a hand that cannot see: travel in front of the scene, approach along -z until something pushes back, press, slide,
// tap, circle, leave, and again elsewhere. The hand knows no surface: contact is the force it feels, the surface normal is that
// force's direction, and how hard it presses is its own slow force control. So it finds and touches whatever scene is loaded; after
// a miss it searches nearer to the middle first, then farther out. Given surface points (aim), it goes to one of them instead: a
// scene may be small, or far from the middle. Given a path, the hand follows that instead of its own script: to its first row, then
// row by row, straight in between; an obstacle holds the stylus, not the hand, which pulls at it. Rows outside the workspace are
// clamped to it, jumps are made at kMaxPathSpeed. A lead (the mouse in the vision window) takes the hand over; after it the script
// goes on with leave, or the path begins again. Every random number comes from the seed. A new aim makes a hand that travels or
// approaches begin a new travel. RT: step, lead and aim yes.
class HandScript {
 public:
  static constexpr std::int64_t kStepNs = 1'000'000;
  static constexpr std::size_t kMaxAims = 16;   // equals Device::kMaxAims, which this header does not see
  static constexpr double kMaxPathSpeed = 1.5;  // m/s; an arm in fast motion

  struct Options {
    std::uint64_t seed = 1;
    Vec3 workspace_min_m = Vec3::Zero();
    Vec3 workspace_max_m = Vec3::Zero();
    Vec3 start_m = Vec3::Zero();
    std::vector<TrajectoryRow> path =
        {};                    // times rise from row to row; if no row has an orientation, the hand tilts as in its script. Empty: no path
    bool repeat_path = false;  // false: the hand stays at the end of the path
  };
  enum class Phase : std::uint8_t { travel, approach, press, slide, tap, circle, leave, led, path };

  explicit HandScript(const Options& options);

  // One step of kStepNs. Takes what the hand feels now (device point, force on it, both in W), returns its goal for the step's end.
  HandIntention step(const Vec3& p_WD, const Vec3& force_n) noexcept;
  void lead(const std::optional<Vec3>& p_WH) noexcept;
  // Points of the surface, frame W; those that are not finite or outside the workspace are left out. The same points change nothing.
  void aim(std::span<const Vec3> p_WA) noexcept;
  Phase phase() const noexcept { return phase_; }

 private:
  double uniform(double low, double high) noexcept;
  void feel(const Vec3& p_WD, const Vec3& force_n) noexcept;
  void enter(Phase phase) noexcept;
  Vec3 within_workspace(const Vec3& p_W) const noexcept;
  Phase first_phase() const noexcept { return options_.path.empty() ? Phase::travel : Phase::path; }
  Vec3 point_of_path() noexcept;
  void follow_path() noexcept;
  void choose_aim() noexcept;
  bool move_towards(const Vec3& goal, double speed_m_per_s) noexcept;
  void follow_surface(const Vec3& p_WD, double turn_rad_per_s) noexcept;
  void turn_tangent(double angle_rad) noexcept;
  void tap(const Vec3& p_WD) noexcept;
  void advance_phase(const Vec3& p_WD) noexcept;
  HandIntention intention() noexcept;
  Quat turn_of_path() const noexcept;

  Options options_;
  std::mt19937_64 random_;
  Phase phase_ = Phase::travel;
  double phase_s_ = 0.0;
  double phase_end_s_ = 0.0;
  double tilt_time_s_ = 0.0;     // time of the script's tilt; stands still while the hand is led, which then holds the stylus still
  Vec3 hand_m_;                  // the intended position, moved step by step
  Vec3 aim_m_ = Vec3::Zero();    // the goal of travel and of leave, or the upper position of a tap
  Vec3 normal_ = Vec3::UnitZ();  // normal of the surface touched last
  Vec3 tangent_ = Vec3::UnitX();
  Vec3 filtered_force_n_ = Vec3::Zero();  // the force through a low-pass filter, as a hand feels it
  Vec3 contact_m_ = Vec3::Zero();         // device point when last in contact
  std::optional<Vec3> lead_m_;
  std::array<Vec3, kMaxAims> aims_m_;
  std::size_t aim_count_ = 0;
  double press_n_ = 1.0;
  double slide_m_per_s_ = 0.08;
  double turn_rad_per_s_ = 0.0;
  double contact_lost_s_ = 0.0;    // time since the last contact
  double search_share_ = 0.3;      // how far from the middle the hand searches: not metres, a share of half the workspace
  bool has_orientations_ = false;  // the path has orientations
  double path_s_ = 0.0;            // time since the first row of the path; below 0: the hand is on the way there
  std::size_t path_row_ = 0;       // the last row that has been reached
  int taps_left_ = 0;
  bool is_striking_ = false;
};

}  // namespace hapton
