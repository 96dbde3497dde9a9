#include "closed_loop/hand_model.h"

#include <algorithm>
#include <array>

namespace hapton {
namespace {

// Ranges in closed-loop studies: mass 0.05-1 kg, damping 1-25 Ns/m, stiffness 0-1000 N/m.
constexpr std::array kHands = {
    HandPreset{"off", {}, "nobody holds the device"},
    HandPreset{"light", {0.05, 1.0, 20.0}, "low end of the ranges in closed-loop studies: two fingers"},
    HandPreset{"stylus", {0.15, 5.0, 500.0}, "stylus grip: 0.1-0.2 kg, 2-10 Ns/m, 200-1000 N/m in closed-loop studies"},
    HandPreset{"arm", {0.8, 5.5, 30.0}, "relaxed arm in closed-loop studies: 0.8 kg, 5.5 Ns/m, 30 N/m"},
    HandPreset{"firm", {1.0, 10.0, 50.0}, "firm grip in closed-loop studies: 1 kg, 10 Ns/m, 50 N/m"},
};

}  // namespace

std::span<const HandPreset> hand_presets() noexcept { return kHands; }

std::optional<HandModel> find_hand_preset(std::string_view name) noexcept {
  const auto* const found = std::find_if(kHands.begin(), kHands.end(), [&](const HandPreset& hand) { return hand.name == name; });
  if (found == kHands.end()) return std::nullopt;
  return found->model;
}

std::string hand_preset_names() {
  std::string names;
  for (const HandPreset& hand : kHands) names += (names.empty() ? "" : ", ") + std::string(hand.name);
  return names;
}

}  // namespace hapton
