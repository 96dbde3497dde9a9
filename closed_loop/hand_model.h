#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hapton {

// A hand that holds the device point: a mass that moves with the device, and a spring and a damper to the intended position.
struct HandModel {
  double mass_kg = 0.0;
  double damping_ns_per_m = 0.0;
  double stiffness_n_per_m = 0.0;
};

struct HandPreset {
  std::string_view name;
  HandModel model;
  std::string_view source;
};

// off, light, stylus, arm, firm: from nobody at the device to a firm grip. RT: yes.
std::span<const HandPreset> hand_presets() noexcept;
// The model of the preset of that name; none if there is no such preset. RT: yes.
std::optional<HandModel> find_hand_preset(std::string_view name) noexcept;
// The names for help texts, "off, light, ...". RT: set-up only.
std::string hand_preset_names();

}  // namespace hapton
