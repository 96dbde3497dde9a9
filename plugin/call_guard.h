#pragma once

#include <cstdint>
#include <string>

#include "core/math/types.h"
#include "plugin/call_budget.h"
#include "plugin/plugin_file.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// Why a plug-in is not called any more.
struct CutOff {
  enum class Reason : std::uint8_t { none, not_finite, too_strong, too_slow, exception };
  Reason reason = Reason::none;
  double value = 0.0;  // N, Nm or s
  double limit = 0.0;
  bool is_torque = false;

  explicit operator bool() const noexcept { return reason != Reason::none; }
};

// Such as "it gave 1e+09 N, its limit is 2 N". RT: no.
std::string describe(const CutOff& cut_off);

class CallGuard;
// One line, such as "1000 calls, maximum 1.2 N; p50 0.1 us, p99 0.2, worst 3; CUT OFF: why". RT: no.
std::string describe_calls(const CallGuard& guard);

struct PluginForce {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();
};

// Calls the step of one plug-in: measures the calls, checks their results, and cuts the plug-in off for good if it takes too long, gives a
// force that is not finite or too strong, or throws. The force of a plug-in that is cut off fades from its last good one to zero. Frame:
// the caller's. Units: SI. RT: all but construction and the report: no heap, lock or system call. Threads: one.
class CallGuard {
 public:
  // How long the last good force takes to fade after the cut; the same as ForceFade::kInContactS.
  static constexpr double kFadeS = 0.1;

  // Pre: the clock outlives this object.
  CallGuard(const Clock& clock, std::int64_t budget_ns, double max_force_n, double max_torque_nm)
      : clock_(clock), budget_(budget_ns), max_force_n_(max_force_n), max_torque_nm_(max_torque_nm) {}

  // Calls the plug-in, unless it is cut off, and returns the force to use. run: runs the plug-in and puts its result into the argument.
  template <class Run>
  PluginForce step(double dt_s, Run&& run) noexcept {
    if (!cut_off_) {
      PluginForce plugin_force;
      const std::int64_t begin_ns = clock_.now_ns();
      const bool has_returned = call_plugin([&] { run(plugin_force); });
      evaluate(clock_.now_ns() - begin_ns, has_returned, plugin_force);
    }
    return cut_off_ ? fade(dt_s) : last_good_;
  }

  // For a new session: forgets the last force, so that no force of the session before is felt.
  void forget() noexcept {
    last_good_ = {};
    fade_share_ = 0.0;
  }
  // Cuts the plug-in off because of a fault that the caller has found.
  void cut(const CutOff& cut_off) noexcept;

  const CutOff& cut_off() const noexcept { return cut_off_; }
  const LatencyHistogram& times() const noexcept { return times_; }
  double most_n() const noexcept { return largest_force_n_; }

 private:
  void evaluate(std::int64_t spent_ns, bool has_returned, const PluginForce& plugin_force) noexcept;
  CutOff find_fault(std::int64_t spent_ns, bool has_returned, const PluginForce& plugin_force) noexcept;
  PluginForce fade(double dt_s) noexcept;

  const Clock& clock_;
  CallBudget budget_;
  double max_force_n_;
  double max_torque_nm_;
  LatencyHistogram times_;
  PluginForce last_good_;    // the last good force
  double fade_share_ = 0.0;  // part of last_good_ that is still felt after the cut
  double largest_force_n_ = 0.0;
  CutOff cut_off_;
};

}  // namespace hapton
