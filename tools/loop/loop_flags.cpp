#include "tools/loop/loop_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/base/similar_word.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxNumbers = 1'000'000;  // the most in one list; a free choice

template <class Presets>
Result<std::vector<std::string>> names_of(const std::string& flag, const std::string& list, const Presets& presets) {
  std::vector<std::string_view> known;
  for (const auto& preset : presets) known.push_back(preset.name);
  std::vector<std::string> names;
  for (const std::string& name : split_list(list)) {
    if (name == "all") {
      names.insert(names.end(), known.begin(), known.end());
      continue;
    }
    if (std::find(known.begin(), known.end(), name) == known.end())
      return fail("{} '{}' is unknown{}", flag, name, similar_word_hint(name, known));
    names.push_back(name);
  }
  if (names.empty()) return fail("{}: no name is given; known are {}, and all", flag, fmt::join(known, ", "));
  return names;
}

std::optional<double> number_of(std::string_view word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

constexpr double kMinAmplifierHz = 0.1;     // a slower amplifier cannot follow a hand
constexpr double kMinJointKg = 1e-4;        // lighter and stiffer joints only take computing time
constexpr double kMaxJointStiffness = 1e7;  // N/m; far above any joint, as is the next value, in Ns/m
constexpr double kMaxJointDamping = 1e3;

// Replaces the device's joints. The masses beyond the joints are part of the device's mass.
Result<void> change_joints(const std::vector<std::string>& joints, DeviceModel& device) {
  if (joints.empty()) return {};
  if (joints.size() > device.modes.size()) return fail("--joint: {} joints at most, not {}", device.modes.size(), joints.size());
  device.mode_count = static_cast<int>(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto numbers = read_numbers("--joint", joints[i]);
    if (!numbers) return tl::unexpected(numbers.error());
    if (numbers->size() != 3) return fail("--joint '{}': give MASS,STIFFNESS,DAMPING in kg, N/m and Ns/m", joints[i]);
    const StructuralMode mode = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    if (!(mode.mass_kg >= kMinJointKg) || !(mode.stiffness_n_per_m > 0.0 && mode.stiffness_n_per_m <= kMaxJointStiffness) ||
        !(mode.damping_ns_per_m >= 0.0 && mode.damping_ns_per_m <= kMaxJointDamping)) {
      return fail("--joint '{}': the mass is at least {:g} kg, the stiffness above 0 and at most {:g} N/m, the damping 0 to {:g} Ns/m",
                  joints[i], kMinJointKg, kMaxJointStiffness, kMaxJointDamping);
    }
    device.modes[i] = mode;
  }
  if (!(device.motor_mass_kg() >= kMinJointKg)) {
    return fail("--joint: beyond the joints are {:g} kg of the {:g} kg of the device; some have to remain at the motors",
                device.mass_kg - device.motor_mass_kg(), device.mass_kg);
  }
  return {};
}

Result<void> change_device(const LoopFlags& flags, DeviceModel& device) {
  if (auto changed = change_joints(flags.joints, device); !changed) return changed;
  device = device.with_modes(flags.modes);
  if (flags.friction_n) device.friction_n = *flags.friction_n;
  if (flags.encoder_step_m) device.encoder_step_m = *flags.encoder_step_m;
  if (flags.amplifier_hz) device.amplifier_hz = *flags.amplifier_hz;
  return {};
}

Result<std::vector<NamedLoop>> own_loop(const LoopFlags& flags) {
  if (!flags.device.empty()) return fail("--device and --mass-kg exclude each other: --mass-kg is the mass of device and hand together");
  if (!flags.damping_ns_per_m) return fail("--mass-kg needs --damping-ns-per-m, of device and hand together");
  NamedLoop loop;
  loop.device = "own";
  loop.hand = "own";
  loop.device_model = {.mass_kg = *flags.mass_kg, .damping_ns_per_m = *flags.damping_ns_per_m};
  loop.hand_model.stiffness_n_per_m = flags.hand_stiffness_n_per_m.value_or(0.0);
  if (auto changed = change_device(flags, loop.device_model); !changed) return tl::unexpected(changed.error());
  return std::vector{loop};
}

}  // namespace

void add_loop_flags(CommandLine command, LoopFlags& flags, bool several) {
  const std::string list = several ? ", several with commas between, or all" : "";
  command.add_option("--device", flags.device, "Device" + list + "; one of: " + device_preset_names());
  const CommandOption hand = command.add_option("--hand", flags.hand, "Hand" + list + "; one of: " + hand_preset_names()).shows_default();
  const CommandLine own = command.add_group("own loop", "A loop of your own, device and hand together, in place of --device and --hand");
  own.add_option("--mass-kg", flags.mass_kg, "Mass").positive("kilograms").between(1e-4, 1e3).excludes(hand);
  own.add_option("--damping-ns-per-m", flags.damping_ns_per_m, "Viscous damping").between(0.0, 1e5);
  own.add_option("--hand-stiffness-n-per-m", flags.hand_stiffness_n_per_m,
                 "Stiffness of the hand towards its intended position (default: 0)")
      .between(0.0, 1e6);
  const CommandLine changes = command.add_group("changes", "These replace values of the device");
  changes.add_option("--friction", flags.friction_n, "Coulomb friction").between(0.0, 1e3);
  changes.add_option("--quantisation", flags.encoder_step_m, "Encoder step at the device point").between(0.0, 0.1);
  changes.add_option("--amplifier", flags.amplifier_hz, "Bandwidth of the amplifier, at least 0.1 Hz; 0: no lag").between(0.0, 1e5);
  changes.add_option("--joint", flags.joints,
                     "Compliant joint, as MASS,STIFFNESS,DAMPING: of the mass beyond it (part of the device's), in kg, N/m and Ns/m; "
                     "twice for two, from the motors outwards");
  changes.add_option("--modes", flags.modes, "Number of structural modes, at most; 0: rigid")
      .between(0, DeviceModel::kMaxModes)
      .shows_default();
}

Result<std::vector<NamedLoop>> loops_of(const LoopFlags& flags) {
  if (flags.amplifier_hz && *flags.amplifier_hz > 0.0 && *flags.amplifier_hz < kMinAmplifierHz) {
    return fail("--amplifier {:g}: give 0 for no lag, or at least {:g} Hz", *flags.amplifier_hz, kMinAmplifierHz);
  }
  if (flags.mass_kg) return own_loop(flags);
  if (flags.damping_ns_per_m || flags.hand_stiffness_n_per_m)
    return fail("--damping-ns-per-m and --hand-stiffness-n-per-m need --mass-kg, the mass of device and hand together");
  if (flags.device.empty()) {
    return fail("give --device, one of: {}; or --mass-kg, --damping-ns-per-m and --hand-stiffness-n-per-m", device_preset_names());
  }
  const auto devices = names_of("--device", flags.device, device_presets());
  if (!devices) return tl::unexpected(devices.error());
  const auto hands = names_of("--hand", flags.hand, hand_presets());
  if (!hands) return tl::unexpected(hands.error());
  std::vector<NamedLoop> loops;
  for (const std::string& device : *devices) {
    for (const std::string& hand : *hands) {
      NamedLoop loop{device, hand, find_device_preset(device)->model, *find_hand_preset(hand), find_device_preset(device)->limits};
      if (auto changed = change_device(flags, loop.device_model); !changed) return tl::unexpected(changed.error());
      loops.push_back(loop);
    }
  }
  return loops;
}

Result<std::vector<double>> read_numbers(const std::string& flag, const std::string& text) {
  std::vector<double> numbers;
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) {
    for (const std::string& word : split_list(text)) {
      const auto number = number_of(word);
      if (!number) return fail("{} '{}' is not a number; give 1000, or 250,1000,4000, or 0:500:11, or 250:20000:7log", flag, word);
      numbers.push_back(*number);
    }
    if (numbers.empty()) return fail("{}: no number is given", flag);
    return numbers;
  }
  const std::size_t second = text.find(':', colon + 1);
  const bool is_log = text.ends_with("log");
  const std::string count_text = second == std::string::npos ? "" : text.substr(second + 1, text.size() - second - 1 - (is_log ? 3 : 0));
  const auto low = number_of(std::string_view(text).substr(0, colon));
  const auto high = second == std::string::npos ? std::nullopt : number_of(std::string_view(text).substr(colon + 1, second - colon - 1));
  const auto count = number_of(count_text);
  if (!low || !high || !count || *count < 2.0 || *count != std::floor(*count) || *count > static_cast<double>(kMaxNumbers)) {
    return fail("{} '{}' is not a range; give LOW:HIGH:COUNT, or LOW:HIGH:COUNTlog for equal ratios", flag, text);
  }
  if (is_log && !(*low > 0.0 && *high > 0.0)) return fail("{} '{}': equal ratios need numbers above zero", flag, text);
  for (int i = 0; i < static_cast<int>(*count); ++i) {
    const double share = i / (*count - 1.0);
    numbers.push_back(is_log ? *low * std::pow(*high / *low, share) : *low + share * (*high - *low));
  }
  return numbers;
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    if (comma > at) words.push_back(text.substr(at, comma - at));
    at = comma + 1;
  }
  return words;
}

}  // namespace hapton
