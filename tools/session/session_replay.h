#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "haptic_step/haptics_step.h"
#include "link/messages.h"
#include "recording/object_changes.h"
#include "tools/session/recorded_shapes.h"

namespace hapton {

// The setups that haptics nodes sent in a recording, by sender and HapticsSetup::method_serial.
using HapticsSetups = std::map<std::pair<std::uint64_t, std::uint32_t>, HapticsSetup>;

// Makes the method that a setup names. Error: the scene file cannot be read or is not the recorded one, or the method cannot be made.
using MakeTouch = std::function<Result<std::unique_ptr<TouchStep>>(const HapticsSetup& setup)>;

// The states of the materials that haptics nodes sent in a recording, by sender and MaterialState::serial.
using MaterialStates = std::map<std::pair<std::uint64_t, std::uint32_t>, MaterialState>;

// The moves of objects by programs, by sender, serial and object. Serial 0, not moved yet, has an entry for each object; others have one.
using ObjectMoves = std::map<std::tuple<std::uint64_t, std::uint32_t, std::int32_t>, ObjectMove>;

// The carves and undos that haptics nodes announced, by sender and serial. A sender that loads another scene starts its serials anew; such
// a session cannot be replayed in any case, so only the entries of its first process are kept.
class ReplayedCarves {
 public:
  void add(const RecordedCarve& carve);
  // Null: the recording does not have it.
  const Carves::One* find(std::uint64_t sender, std::uint32_t serial) const;

 private:
  struct Sender {
    std::uint32_t process = 0;
    std::vector<std::optional<Carves::One>> by_serial = {};
  };
  std::map<std::uint64_t, Sender> senders_;
};

// Makes the materials of a state, in the scene and with the coupling that a setup names. Error: as for MakeTouch.
using MakeMaterials = std::function<Result<std::vector<Material>>(const HapticsSetup& setup, const MaterialState& state)>;

// The result of replaying a recording.
struct ReplayCounts {
  std::uint64_t steps = 0;
  std::uint64_t contact_steps = 0;
  std::uint64_t compared = 0;
  std::uint64_t different = 0;
  std::uint64_t lost_replies = 0;  // replayed, but not compared, because the recorded reply was lost
  std::uint64_t not_compared = 0;  // replies that depend on steps before the recording or on lost ones: in contact before the first step
                                   // in free space; with effects, all steps after a lost one; with a carvable object, those until the hand
                                   // has rested in free space
  std::uint64_t unknown_method =
      0;  // replies whose method, view, materials, moves, shapes or carves are not in the recording, or not yet: their messages were lost
  std::uint64_t missing_states = 0;  // samples with a reply whose DeviceState is not in the recording
  std::uint64_t missing_views = 0;   // replies that name a ViewTransform that is not in the recording or has two poses there
  double max_difference_n = 0.0;
  std::string first_difference;  // text about the first step that differs, in one line; empty: none does
};

// Replays a recorded session in the order of the haptics node: call on_state, on_view, on_shape and on_reply with the recording's entries,
// in their order. It repeats the steps of the samples that had a reply, with the view, method, materials and so on that the reply names,
// and compares force, torque, offset and contact to the last bit. Error: one line, also if it cannot be replayed. RT: no. Threads: one.
class SessionReplay {
 public:
  // A recording in which no materials change needs only the first two.
  SessionReplay(HapticsSetups setups, MakeTouch make_touch, MaterialStates materials = {}, MakeMaterials make_materials = {});

  // Sets effects from shared libraries, which must be those that the recording names. Pre: no entry yet; effects outlives this.
  void use_effects(PluginEffects* effects) { effects_ = effects; }

  // Sets the moves of a recording in which programs moved objects. Pre: no entry yet.
  void use_moves(ObjectMoves moves) { moves_ = std::move(moves); }

  // Sets how to find the objects that programs deform, and their first shapes; the others come by on_shape(). Pre: no entry yet.
  void use_program_shapes(FindProgramShape find, FirstShapes first = {}) {
    find_program_shape_ = std::move(find);
    shapes_.use_first(std::move(first));
  }

  // Sets the carves of a recording in which material was carved. Pre: no entry yet.
  void use_carves(ReplayedCarves carves) { carves_ = std::move(carves); }

  void on_state(const DeviceState& state);
  void on_view(const ViewTransform& view);
  void on_shape(std::uint64_t sender, const ObjectShape& shape) { shapes_.add(sender, shape); }
  void on_shape(std::uint64_t sender, const ShapeStart& start) { shapes_.add(sender, start); }
  Result<void> on_reply(std::uint64_t sender, const ForceCommand& command);
  // Replays the samples that still wait for reordered replies. To be called after the last entry.
  Result<void> finish();

  const ReplayCounts& counts() const { return counts_; }

 private:
  Result<void> settle(std::uint64_t up_to_sample);
  Result<void> begin_process(std::uint64_t sender, const ForceCommand& first);
  Result<void> step_method(const ForceCommand& command);
  void step_lost(const ForceCommand& before);
  Result<void> change_method(std::uint32_t serial);
  Result<void> change_materials(std::uint32_t serial);
  Result<bool> find_materials(const HapticsSetup& setup, std::uint32_t serial);
  void begin_moves(std::uint32_t serial);
  void change_moves(std::uint32_t serial);
  bool apply_move(std::uint32_t serial);
  void change_shapes(std::uint32_t serial);
  bool restore_shapes(std::int64_t scene_time_ns);
  Result<void> rebuild_surfaces(const ForceCommand& command);
  RecordedShapes::FindShape find_shape() const;
  bool is_known() const {
    return is_method_known_ && is_view_known_ && are_materials_known_ && are_moves_known_ && are_shapes_known_ && are_carves_known_;
  }
  std::optional<Sculpture> make_shape(std::uint32_t serial) const;
  void repeat_carves(std::uint32_t serial);
  void undo_carves(std::uint32_t serial, bool is_after_lost);
  bool has_rested(const ForceCommand& command) const;
  Result<void> regain_certainty(const ForceCommand& command);
  Result<void> rebuild_bodies(const ForceCommand& command);
  void change_view(std::uint32_t revision);
  void lose_view();
  std::optional<ForceCommand> step(std::uint64_t sample);
  void compare(const ForceCommand& recorded, const ForceCommand& replayed);
  Result<void> check_effects(const HapticsSetup& setup) const;
  Result<std::unique_ptr<TouchStep>> make_method_of(const HapticsSetup& setup, double* offset_m = nullptr);

  HapticsSetups setups_;
  MakeTouch make_touch_;
  MaterialStates material_states_;
  ObjectMoves moves_;
  RecordedShapes shapes_;
  FindProgramShape find_program_shape_;
  ReplayedCarves carves_;
  std::optional<Sculpture> uncarved_;  // the bodies before any carve; none: no object can be carved
  PluginEffects* effects_ = nullptr;   // null: none
  MakeMaterials make_materials_;
  std::map<std::uint64_t, DeviceState> states_;               // by sample; not replayed yet
  std::map<std::uint32_t, ViewTransform> views_ = {{0, {}}};  // by revision; 0: as the scene file has it
  std::set<std::uint32_t> ambiguous_views_;                   // revisions with several poses
  std::map<std::uint64_t, ForceCommand> replies_;             // by sample; not replayed yet
  std::unique_ptr<HapticsStep> step_;
  std::uint64_t sender_ = 0;
  std::uint64_t last_sample_ = 0;  // last replayed sample
  std::uint32_t method_serial_ = 0;
  std::uint32_t material_serial_ = 0;
  std::vector<Material> materials_;   // of material_serial_; empty: those of the scene
  HapticsSetup setup_;                // the setup in use
  bool is_method_known_ = false;      // the method in use is the recorded one
  bool is_view_known_ = true;         // the view of the newest reply is in the recording
  bool are_materials_known_ = false;  // the materials in use are the recorded ones
  std::uint32_t move_serial_ = 0;     // serial of the newest move that was applied
  bool are_moves_known_ = true;       // all moves up to move_serial_ are in the recording; later ones are not applied
  std::uint32_t shape_serial_ = 0;    // serial of the newest shape that was begun
  bool are_shapes_known_ = true;      // it is known where the surfaces are after all shapes up to shape_serial_
  std::vector<int> deformed_;         // the objects that programs deform
  bool are_carves_known_ = true;      // all carves of the bodies in their present shape are in the recording
  std::int64_t last_busy_ns_ = 0;     // time of the newest sample in contact, with a button down, or after an unknown step
  std::int64_t rebuilt_ns_ = 0;       // time of the sample at which the bodies were last made again from their carves
  bool is_certain_ = false;           // the state of the method does not depend on unknown steps
  std::int64_t first_time_ns_ = 0;
  ReplayCounts counts_;
};

}  // namespace hapton
