#pragma once

#include <optional>
#include <string>
#include <vector>

#include "closed_loop/zwidth.h"
#include "core/base/result.h"
#include "tools/command_line.h"

namespace hapton {

// A device in a hand as a command line names them.
struct LoopFlags {
  std::string device;
  std::string hand = "stylus";
  std::optional<double> mass_kg;
  std::optional<double> damping_ns_per_m;
  std::optional<double> hand_stiffness_n_per_m;
  std::optional<double> friction_n;
  std::optional<double> encoder_step_m;
  std::optional<double> amplifier_hz;
  std::vector<std::string> joints;  // "MASS,STIFFNESS,DAMPING" each
  int modes = DeviceModel::kMaxModes;
};

// What the flags name.
struct NamedLoop {
  std::string device;
  std::string hand;
  DeviceModel device_model;
  HandModel hand_model;
  DeviceLimits limits;

  // Given by --mass-kg and the like; device and hand are then both called "own", in JSON and CSV too.
  bool is_own() const { return device == "own"; }
  // For people: "touch in hand stylus", or "own loop".
  std::string title() const { return is_own() ? "own loop" : device + " in hand " + hand; }
};

// --device, --hand, or --mass-kg, --damping-ns-per-m and --hand-stiffness-n-per-m, and what changes a preset. `several`: lists may be
// given. Pre: `flags` outlives the parsing.
void add_loop_flags(CommandLine command, LoopFlags& flags, bool several);

// Every device with every hand. Error: an unknown name, with the one that may be meant; neither or both of preset and own loop; a model
// that cannot be.
Result<std::vector<NamedLoop>> loops_of(const LoopFlags& flags);

// Numbers: "1000", "250,1000,4000", "0:500:11" (evenly) or "250:20000:7log" (by equal ratios). Error: none of these.
Result<std::vector<double>> read_numbers(const std::string& flag, const std::string& text);

// "a,b" into its words.
std::vector<std::string> split_list(const std::string& text);

}  // namespace hapton
