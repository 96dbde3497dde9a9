// An effect that does what its parameters say: does=push|nan|torque_nan|huge|strong|sleep|forever|abort|exception|copy|lean, after=CALLS,
// ms=MILLISECONDS, n=NEWTONS. In create: does=reject|reject_lines|blank|silent|create_exception; in reset: does=reset_exception. It aborts
// if it is destroyed without having been created, or reset after it gave NaN. Compiled with another ODD_ABI or ODD_SIZE,
// it is a plug-in for another release of Hapton.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include "plugin/hapton_plugin.h"

extern "C" void nowhere_to_be_found(void* effect, const hapton_effect_input* input, hapton_effect_output* output);

namespace {

struct OddEffect {
  std::string does = "push";
  long after = 0;
  double ms = 50.0;
  double n = 1.0;
  long calls = 0;
};

[[maybe_unused]] void* create(const hapton_request* request) {
  OddEffect made;
  for (std::size_t p = 0; p < request->parameter_count; ++p) {
    const std::string key = request->parameters[p].key;
    const std::string value = request->parameters[p].value;
    if (key == "does") made.does = value;
    if (key == "after") made.after = std::atol(value.c_str());
    if (key == "ms") made.ms = std::atof(value.c_str());
    if (key == "n") made.n = std::atof(value.c_str());
  }
  if (made.does == "silent") return nullptr;
  if (made.does == "blank") return std::snprintf(request->why, request->why_size, " \n "), nullptr;
  if (made.does == "reject_lines") return std::snprintf(request->why, request->why_size, "n is\nodd\t \n"), nullptr;
  if (made.does == "create_exception") throw std::runtime_error("not today");
  if (made.does == "reject") {
    std::snprintf(request->why, request->why_size, "n must be\nless than %g", made.n);
    return nullptr;
  }
  return new OddEffect(made);
}

[[maybe_unused]] void reset(void* effect) {
  OddEffect& odd = *static_cast<OddEffect*>(effect);
  if (odd.does == "nan" && odd.calls > odd.after) std::abort();
  if (odd.does == "reset_exception") throw std::runtime_error("not now");
  odd.calls = 0;
}

[[maybe_unused]] void step(void* effect, const hapton_effect_input* input, hapton_effect_output* output) {
  OddEffect& odd = *static_cast<OddEffect*>(effect);
  output->force_n[0] = odd.n;
  if (odd.does == "copy") {
    for (int k = 0; k < 3; ++k) output->force_n[k] = 0.1 * input->velocity_m_per_s[k];
    for (int k = 0; k < 3; ++k) output->torque_nm[k] = 0.01 * input->contact_force_n[k];
  }
  if (odd.does == "lean") output->force_n[0] = input->time_s + input->dt_s + static_cast<double>(input->buttons + input->sample);
  if (odd.calls++ < odd.after) return;
  if (odd.does == "nan") output->force_n[1] = std::nan("");
  if (odd.does == "torque_nan") output->torque_nm[1] = std::nan("");
  if (odd.does == "huge") output->force_n[2] = std::numeric_limits<double>::max();
  if (odd.does == "strong") output->force_n[2] = 1e9;
  if (odd.does == "sleep") std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(odd.ms));
  if (odd.does == "exception") throw std::runtime_error("through the boundary");
  if (odd.does == "abort") std::abort();
  for (volatile bool is_stuck = odd.does == "forever"; is_stuck;) {
  }
}

[[maybe_unused]] void destroy(void* effect) {
  if (effect == nullptr) std::abort();
  delete static_cast<OddEffect*>(effect);
}

}  // namespace

#ifndef ODD_ABI
#define ODD_ABI HAPTON_PLUGIN_ABI
#endif
#ifndef ODD_SIZE
#define ODD_SIZE sizeof(hapton_effect_input)
#endif
#ifndef ODD_STEP
#define ODD_STEP step
#endif
#ifndef ODD_MAX_N
#define ODD_MAX_N 2.0
#endif
#ifndef ODD_MAX_NM
#define ODD_MAX_NM 0.5
#endif
#ifndef ODD_RESET
#define ODD_RESET reset
#endif
#ifndef ODD_DESTROY
#define ODD_DESTROY destroy
#endif
#ifndef ODD_IS_NOTHING
const hapton_effect_api hapton_effect = {ODD_ABI,    sizeof(hapton_effect_api),
                                         ODD_SIZE,   sizeof(hapton_effect_output),
                                         "odd one",  ODD_MAX_N,
                                         ODD_MAX_NM, create,
                                         ODD_RESET,  ODD_STEP,
                                         ODD_DESTROY};
#endif
