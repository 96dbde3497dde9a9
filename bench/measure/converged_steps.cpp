#include "bench/measure/converged_steps.h"

#include <utility>

#include "core/force/proxy/proxy_method.h"

namespace hapton {
namespace {

constexpr int kMaxRepeats = 1024;  // as in hapton stress; ends the repetition of a step that never converges

}  // namespace

Result<ConvergedSteps> ConvergedSteps::make(const MethodSettings& settings, const TouchScene& scene) {
  auto method = make_method(settings, scene);
  if (!method) return tl::unexpected(method.error());
  return ConvergedSteps(std::move(*method), scene);
}

ConvergedSteps::Window ConvergedSteps::compute(const TouchTrajectory& trajectory, std::size_t start, std::size_t count) {
  const std::size_t first = trajectory.reset_every == 0 ? 0 : start - start % trajectory.reset_every;
  TouchInput input;
  input.p_WD = trajectory.p_SD[first];
  touch_.reset(input);
  Window window;
  const auto* proxy = dynamic_cast<const ProxyMethod*>(method_.get());
  for (std::size_t i = first; i <= start + count; ++i) {
    input.p_WD = trajectory.p_SD[i];
    TouchOutput output = touch_.step(input);
    if (i == start) {
      window.begins_sliding = proxy == nullptr || proxy->is_sliding();
      window.begins_at = method_->carried_from().value_or(input.p_WD);
    }
    if (i <= start) continue;
    for (int repeat = 0; method_->carried_from() && repeat < kMaxRepeats; ++repeat) output = touch_.step(input);
    window.felt.push_back({.device = input.p_WD, .proxy = input.p_WD + output.visual_offset_m, .force_n = output.force_n});
  }
  return window;
}

}  // namespace hapton
