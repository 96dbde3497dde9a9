#include "plugin/call_guard.h"

#include <algorithm>

#include <fmt/core.h>

namespace hapton {
namespace {

// A result that is at its limit may exceed it by rounding.
constexpr double kRounding = 1.001;

}  // namespace

std::string describe(const CutOff& cut_off) {
  const char* unit = cut_off.is_torque ? "Nm" : "N";
  switch (cut_off.reason) {
    case CutOff::Reason::none:
      break;
    case CutOff::Reason::not_finite:
      return "it gave a result that is not finite";
    case CutOff::Reason::too_strong:
      return fmt::format("it gave {:.4g} {}, its limit is {:.4g} {}", cut_off.value, unit, cut_off.limit, unit);
    case CutOff::Reason::too_slow:
      return fmt::format("it took too long too often, {:.3g} ms in the last call; its budget is {:.3g} ms", 1e3 * cut_off.value,
                         1e3 * cut_off.limit);
    case CutOff::Reason::exception:
      return "it threw a C++ exception";
  }
  return "";
}

std::string describe_calls(const CallGuard& guard) {
  const LatencyHistogram& times = guard.times();
  std::string text = fmt::format("{} calls, maximum {:.3f} N", times.count(), guard.most_n());
  if (times.count() > 0) {
    text += fmt::format("; p50 {:.2f} us, p99 {:.2f}, worst {:.2f}", 1e-3 * times.quantile_ns(0.5), 1e-3 * times.quantile_ns(0.99),
                        1e-3 * static_cast<double>(times.max_ns()));
  }
  return text + (guard.cut_off() ? "; CUT OFF: " + describe(guard.cut_off()) + "\n" : "\n");
}

void CallGuard::evaluate(std::int64_t spent_ns, bool has_returned, const PluginForce& plugin_force) noexcept {
  times_.record(std::max<std::int64_t>(0, spent_ns));
  const CutOff fault = find_fault(spent_ns, has_returned, plugin_force);
  if (fault) return cut(fault);
  last_good_ = plugin_force;
  largest_force_n_ = std::max(largest_force_n_, plugin_force.force_n.norm());
}

CutOff CallGuard::find_fault(std::int64_t spent_ns, bool has_returned, const PluginForce& plugin_force) noexcept {
  if (!has_returned) return {.reason = CutOff::Reason::exception};
  if (!plugin_force.force_n.allFinite() || !plugin_force.torque_nm.allFinite()) return {.reason = CutOff::Reason::not_finite};
  // If a component is so large that the norm overflows, the norm is infinite, and so above any limit.
  const double force_n = plugin_force.force_n.norm();
  const double torque_nm = plugin_force.torque_nm.norm();
  if (force_n > kRounding * max_force_n_) return {.reason = CutOff::Reason::too_strong, .value = force_n, .limit = max_force_n_};
  if (torque_nm > kRounding * max_torque_nm_)
    return {.reason = CutOff::Reason::too_strong, .value = torque_nm, .limit = max_torque_nm_, .is_torque = true};
  if (!budget_.add(spent_ns))
    return {.reason = CutOff::Reason::too_slow,
            .value = 1e-9 * static_cast<double>(spent_ns),
            .limit = 1e-9 * static_cast<double>(budget_.budget_ns())};
  return {};
}

void CallGuard::cut(const CutOff& cut_off) noexcept {
  cut_off_ = cut_off;
  fade_share_ = 1.0;
}

PluginForce CallGuard::fade(double dt_s) noexcept {
  if (fade_share_ <= 0.0) return {};
  fade_share_ -= dt_s / kFadeS;
  if (fade_share_ <= 0.0) return {};
  return {.force_n = fade_share_ * last_good_.force_n, .torque_nm = fade_share_ * last_good_.torque_nm};
}

}  // namespace hapton
