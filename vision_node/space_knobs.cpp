#include "vision_node/space_knobs.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// A slower frame must not make the scene jump.
constexpr double kLongestStepS = 0.1;

}  // namespace

SpaceKnobs::SpaceKnobs(HidOpener opener) : reader_(std::move(opener)) { reader_.start(); }

Vec3 SpaceKnobs::take_turn_degrees(std::int64_t now_ns) {
  const Vec3 turn = reader_.state(now_ns).turn;
  const double passed_s = taken_ns_ < 0 ? 0.0 : std::clamp(1e-9 * static_cast<double>(now_ns - taken_ns_), 0.0, kLongestStepS);
  taken_ns_ = now_ns;
  return passed_s * kFullDegreesPerS * turn.cwiseAbs().cwiseProduct(turn);
}

}  // namespace hapton
