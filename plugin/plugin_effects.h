#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/effects/smooth_velocity.h"
#include "plugin/plugin_effect.h"

namespace hapton {

// One sample, and what the method and the scene's effects computed for it. Frame: W. Units: SI.
struct EffectMoment {
  std::uint64_t sample = 0;
  std::int64_t time_ns = 0;
  double dt_s = 1e-3;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  std::uint32_t buttons = 0;
  Pose X_WS = Pose::Identity();
  bool contact = false;
  Vec3 p_WP = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
};

// All effects from shared libraries of a haptics node, in the order of its command line. RT: step and reset yes; the rest no. Threads: one.
class PluginEffects {
 public:
  // Pre: the clock outlives this object. With a clock that stands still, no call takes too long.
  explicit PluginEffects(const Clock& clock, std::int64_t budget_ns = CallBudget::kDefaultNs) : clock_(clock), budget_ns_(budget_ns) {}

  // Error: one line: the effect cannot be used, or there are kMax already, as many as a recording can name.
  Result<void> add(const PluginChoice& choice);
  static constexpr std::size_t kMax = 3;
  bool empty() const { return effects_.empty(); }

  // The sum of the forces and torques of all effects.
  PluginForce step(const EffectMoment& moment) noexcept;
  // Call it when the next sample is the first of a session, or the hand is elsewhere after a gap in the samples.
  void reset() noexcept;

  // For HapticsSetup::method: " effects=NAME@HASH,NAME@HASH!cut"; empty without effects.
  std::string to_text() const;
  // True: an effect was cut off since the last call of take_notices. RT: yes.
  bool has_notices() const noexcept;
  // One line for the log for each effect that was cut off since the last call.
  std::vector<std::string> take_notices();
  // One line for each effect: calls, largest force, times, and whether it was cut off.
  std::string describe() const;

 private:
  struct Entry {
    std::unique_ptr<PluginEffect> effect;
    bool is_reported = false;
  };

  hapton_effect_input make_input(const EffectMoment& moment) noexcept;

  const Clock& clock_;
  std::int64_t budget_ns_;
  std::vector<Entry> effects_;
  SmoothVelocity velocity_;
  std::int64_t first_ns_ = 0;
  bool is_first_ = true;
};

}  // namespace hapton
