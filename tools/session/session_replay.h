#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "haptic_step/haptics_step.h"
#include "link/messages.h"

namespace hapton {

// The setups that haptics nodes sent in a recording, by sender number and the number of its method.
using HapticsSetups = std::map<std::pair<std::uint64_t, std::uint32_t>, HapticsSetup>;

// Makes the method that a setup names. Error: no such scene, another one than was recorded, an unknown method.
using MakeTouch = std::function<Result<std::unique_ptr<TouchStep>>(const HapticsSetup& setup)>;

// Likewise the states of the materials, by their serial.
using MaterialStates = std::map<std::pair<std::uint64_t, std::uint32_t>, MaterialState>;

// The moves of objects that programs requested, by sender number, serial and object: of serial 0 there is one for each object.
using ObjectMoves = std::map<std::tuple<std::uint64_t, std::uint32_t, std::int32_t>, ObjectMove>;

// Works out the materials of a state, in the scene and with the coupling that a setup names. Error: as above.
using MakeMaterials = std::function<Result<std::vector<Material>>(const HapticsSetup& setup, const MaterialState& state)>;

// The result of replaying a recording.
struct ReplayCounts {
  std::uint64_t steps = 0;
  std::uint64_t contact_steps = 0;
  std::uint64_t compared = 0;
  std::uint64_t different = 0;
  std::uint64_t lost_answers = 0;    // replayed, but the original reply is unknown because it was lost
  std::uint64_t not_compared = 0;    // in contact before the first step in free space, with earlier contact unknown; with effects, or
                                     // what can be carved, all steps after one that is unknown
  std::uint64_t unknown_method = 0;  // computed by a method, or with materials or moves, that the recording does not name: they were lost
  std::uint64_t missing_states = 0;  // with a reply, but the state is not in the recording
  std::uint64_t missing_views = 0;
  double max_difference_n = 0.0;
  std::string first_difference;  // one line; empty: none
};

// Replays a recorded session, in the order of the haptics node: give it the recording's entries one by one. It repeats exactly the steps of
// the samples that had a reply, with the view, the method and the materials that each reply names, and compares force, offset and contact
// to the last bit. RT: no. Threads: one.
class SessionReplay {
 public:
  // A recording without changes of materials needs only the first two.
  SessionReplay(HapticsSetups setups, MakeTouch make_touch, MaterialStates materials = {}, MakeMaterials make_materials = {});

  // Before the first entry: effects from shared libraries, which must be those that the recording names. Pre: outlives this.
  void use_effects(PluginEffects* effects) { effects_ = effects; }

  // Before the first entry: of a recording in which programs moved objects.
  void use_moves(ObjectMoves moves) { moves_ = std::move(moves); }

  void on_state(const DeviceState& state);
  void on_view(const ViewTransform& view);
  Result<void> on_answer(std::uint64_t sender, const ForceCommand& command);
  // Replays what still waits for reordered replies.
  Result<void> finish();

  const ReplayCounts& counts() const { return counts_; }

 private:
  Result<void> settle(std::uint64_t up_to_sample);
  Result<void> begin(std::uint64_t sender, const ForceCommand& first);
  Result<void> step_method(const ForceCommand& command);
  void step_lost(const ForceCommand& before);
  Result<void> change_method(std::uint32_t serial);
  Result<void> change_materials(std::uint32_t serial);
  Result<bool> find_materials(const HapticsSetup& setup, std::uint32_t serial);
  void begin_moves(std::uint32_t serial);
  void change_moves(std::uint32_t serial);
  bool apply_move(std::uint32_t serial);
  bool is_known() const { return is_method_known_ && are_materials_known_ && are_moves_known_; }
  void turn(std::uint32_t revision);
  std::optional<ForceCommand> step(std::uint64_t sample);
  void compare(const ForceCommand& recorded, const ForceCommand& replayed);
  Result<void> check_effects(const HapticsSetup& setup) const;
  Result<std::unique_ptr<TouchStep>> make_method_of(const HapticsSetup& setup, double* offset_m = nullptr);

  HapticsSetups setups_;
  MakeTouch make_touch_;
  MaterialStates material_states_;
  ObjectMoves moves_;
  PluginEffects* effects_ = nullptr;  // null: none
  MakeMaterials make_materials_;
  std::map<std::uint64_t, DeviceState> states_;    // not passed yet
  std::map<std::uint32_t, ViewTransform> views_;   // forwarded, by revision
  std::map<std::uint64_t, ForceCommand> answers_;  // not replayed yet, by sample
  std::unique_ptr<HapticsStep> step_;
  std::uint64_t sender_ = 0;
  std::uint64_t last_sample_ = 0;  // last replayed sample
  std::uint32_t serial_ = 0;
  std::uint32_t material_serial_ = 0;
  std::vector<Material> materials_;   // of that serial; empty: the scene's
  HapticsSetup setup_;                // one of this sender
  bool is_method_known_ = false;      // of the steps now
  bool are_materials_known_ = false;  // likewise
  std::uint32_t move_serial_ = 0;     // of the moves begun
  bool are_moves_known_ = true;       // all of them
  bool is_certain_ = false;           // no unknown earlier contact matters any more
  std::int64_t first_time_ns_ = 0;
  ReplayCounts counts_;
};

}  // namespace hapton
