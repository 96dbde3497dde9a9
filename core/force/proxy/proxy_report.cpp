// The text about the proxy that people read.
#include <algorithm>
#include <cmath>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

std::string ProxyMethod::describe() const {
  const std::string what = fmt::format(
      "proxy: {} of {} objects built, {} triangles, {:.1f} MB in all; probe radius {:g} m, contact offset {:g} m\n",
      geometry_.built_count(), geometry_.object_count(), geometry_.triangle_count(), static_cast<double>(geometry_.bytes()) * 1e-6,
      (clearance_.offset - kContactOffset) * geometry_.unit_m(), kContactOffset * geometry_.unit_m());
  if (counters_.steps > 0) return what + describe_steps();
  return what + fmt::format(
                    "proxy: work limit {} units (about 0.1 us each) a step, {} where thousands of triangles meet; longer motions continue "
                    "in the next "
                    "step\n",
                    StepWork::kMax, StepWork::kMaxWithLastEvent);
}

std::string ProxyMethod::describe_steps() const {
  const auto n = static_cast<double>(counters_.steps);
  const auto c = static_cast<double>(std::max<std::uint64_t>(counters_.contact_steps, 1));
  const SweptMotion::Counters& swept = swept_.counters();
  std::string text = fmt::format(
      "proxy: {} steps, {:.1f} % in the empty ball, {} in contact; {} events, at most {} in one step, {} flights, {} out of work, at most "
      "{} units of work in one step\n",
      counters_.steps, 100.0 * static_cast<double>(counters_.skipped) / n, counters_.contact_steps, surface_.events(),
      counters_.most_events, counters_.flights, counters_.exhausted, counters_.most_work);
  if (sphere_.queried() > 0) {
    text += fmt::format(
        "proxy: sphere: {:.2f} events a contact step, {} slips, {} flights, {:.3f} triangle cache rebuilds, {:.1f} units of work\n",
        static_cast<double>(sphere_.events()) / c, sphere_.slips(), sphere_.flights(), static_cast<double>(sphere_.gathered()) / c,
        static_cast<double>(sphere_.queried()) / c);
  }
  if (counters_.swept > 0) {
    text += fmt::format("proxy: {} steps by sweeps: {} motions, {} sweeps, {} triangle tests, {} unconverged\n", counters_.swept,
                        swept.motions, swept.sweeps, swept.tests, swept.unconverged);
  }
  if (shading_ > 0.0) {
    text += fmt::format("proxy: force shading {:g}: against the unshaded force {:.3g} % RMS, {:.3g} % at most\n", shading_,
                        100.0 * std::sqrt(counters_.shading_squared / c), 100.0 * counters_.shading_most);
  }
  return text;
}

}  // namespace hapton
