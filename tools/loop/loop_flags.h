#pragma once

#include <optional>
#include <string>
#include <vector>

#include "closed_loop/zwidth.h"
#include "core/base/result.h"
#include "tools/command_line.h"

namespace hapton {

// A device in a hand, as given on the command line.
struct LoopFlags {
  std::string device;
  std::string hand = "stylus";
  std::optional<double> mass_kg;
  std::optional<double> damping_ns_per_m;
  std::optional<double> hand_stiffness_n_per_m;
  std::optional<double> friction_n;
  std::optional<double> encoder_step_m;
  std::optional<double> amplifier_hz;
  std::vector<std::string> joints;  // "MASS,STIFFNESS,DAMPING" in kg, N/m and Ns/m each
  int modes = DeviceModel::kMaxModes;
};

// One loop of device and hand that the flags describe.
struct NamedLoop {
  std::string device;
  std::string hand;
  DeviceModel device_model;
  HandModel hand_model;
  DeviceLimits limits;

  // Whether it was given by --mass-kg and --damping-ns-per-m; device and hand are then both called "own", in JSON and CSV too.
  bool is_own() const { return device == "own"; }
  // For people: "touch in hand stylus", or "own loop".
  std::string title() const { return is_own() ? "own loop" : device + " in hand " + hand; }
};

// Adds --device and --hand; --mass-kg, --damping-ns-per-m and --hand-stiffness-n-per-m in their place; and the flags that change values of
// a device. `several`: --device and --hand may be lists. Pre: `flags` outlives the parsing.
void add_loop_flags(CommandLine command, LoopFlags& flags, bool several);

// Returns every device with every hand. Error: an unknown name, with the one that may be meant; neither a preset nor an own loop, or both;
// an own loop without damping; values that no device can have.
Result<std::vector<NamedLoop>> loops_of(const LoopFlags& flags);

// Reads "1000", "250,1000,4000", "0:500:11" (evenly spaced) or "250:20000:7log" (equal ratios). Error: the text has none of these forms.
Result<std::vector<double>> read_numbers(const std::string& flag, const std::string& text);

// Splits "a,b" at the commas; leaves out empty words.
std::vector<std::string> split_list(const std::string& text);

}  // namespace hapton
