#include "vision_node/space_mouse_rate.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// The longest time that counts: after a slow frame, what the SpaceMouse moves must not jump.
constexpr double kLongestStepS = 0.1;

}  // namespace

SpaceMouseRate::SpaceMouseRate(HidOpener opener, Vec3 SpaceMouseState::*axes, double full_per_s)
    : reader_(std::move(opener)), axes_(axes), full_per_s_(full_per_s) {
  reader_.start();
}

Vec3 SpaceMouseRate::take(std::int64_t now_ns) {
  const Vec3 deflection = reader_.state(now_ns).*axes_;
  const double elapsed_s = last_take_ns_ < 0 ? 0.0 : std::clamp(1e-9 * static_cast<double>(now_ns - last_take_ns_), 0.0, kLongestStepS);
  last_take_ns_ = now_ns;
  return elapsed_s * full_per_s_ * deflection.cwiseAbs().cwiseProduct(deflection);
}

}  // namespace hapton
