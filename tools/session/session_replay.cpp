#include "tools/session/session_replay.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <set>
#include <string_view>

#include "core/base/ns_between.h"
#include "haptic_step/method_text.h"
#include "link/commanded_move.h"

namespace hapton {
namespace {

// Replies are reordered by at most this number of samples; ForceCommand::replied_before covers the same number.
constexpr std::uint64_t kMaxReorder = 64;

// After this time in free space and without a button, a sphere probe that carves has no state left (decision 170).
constexpr std::int64_t kStatelessAfterNs = 300'000'000;
// The bodies are rebuilt at most this often, because making them takes up to a second.
constexpr std::int64_t kRebuildEveryNs = 1'000'000'000;

MadeCarve to_made_carve(const Carves::One& one, std::uint32_t serial) {
  const auto point = [](const Carves::Point& p) { return Vec3(p[0], p[1], p[2]); };
  return {.object = one.object,
          .serial = serial,
          .carve = {point(one.from_m), point(one.to_m), static_cast<double>(one.radius_m)},
          .begins = one.begins,
          .undone = {.first = one.undone_first, .last = one.undone_last}};
}

// False: the carve changes nothing, so it was not made in these bodies with this shape.
bool carve_body(Sculpture& shape, const MadeCarve& made) {
  for (std::size_t body = 0; body < shape.bodies().size(); ++body) {
    if (shape.bodies()[body].object != made.object) continue;
    if (!shape.field(body).would_change(made.carve)) return false;
    shape.field(body).carve(made.carve);
    return true;
  }
  return false;
}

bool same_bits(const Vec3& a, const Vec3& b) { return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0; }

std::string text_of(const Vec3& v) { return fmt::format("({:.17g}, {:.17g}, {:.17g})", v.x(), v.y(), v.z()); }

}  // namespace

void ReplayedCarves::add(const RecordedCarve& carve) {
  constexpr std::uint32_t kMaxSerial = Sculpture::kMaxCarves;
  Sender& sender = senders_.try_emplace(carve.sender, Sender{.process = carve.process}).first->second;
  if (carve.process != sender.process || carve.serial > kMaxSerial) return;
  if (carve.serial >= sender.by_serial.size()) sender.by_serial.resize(carve.serial + 1);
  sender.by_serial[carve.serial] = carve.carve;
}

const Carves::One* ReplayedCarves::find(std::uint64_t sender, std::uint32_t serial) const {
  const auto known = senders_.find(sender);
  if (known == senders_.end() || serial >= known->second.by_serial.size()) return nullptr;
  const std::optional<Carves::One>& one = known->second.by_serial[serial];
  return one ? &*one : nullptr;
}

SessionReplay::SessionReplay(HapticsSetups setups, MakeTouch make_touch, MaterialStates materials, MakeMaterials make_materials)
    : setups_(std::move(setups)),
      make_touch_(std::move(make_touch)),
      material_states_(std::move(materials)),
      make_materials_(std::move(make_materials)) {}

void SessionReplay::on_state(const DeviceState& state) {
  if (first_time_ns_ == 0) first_time_ns_ = state.sample_time_ns;
  states_[state.sample] = state;
}

void SessionReplay::on_view(const ViewTransform& view) {
  const auto [known, is_new] = views_.emplace(view.revision, view);
  if (!is_new && known->second.X_WS != view.X_WS) ambiguous_views_.insert(view.revision);
}

Result<void> SessionReplay::on_reply(std::uint64_t sender, const ForceCommand& command) {
  if (step_ == nullptr || sender != sender_) {
    if (const auto settled = finish(); !settled) return settled;
    if (const auto begun = begin_process(sender, command); !begun) return begun;
  }
  if (command.echo_sample <= last_sample_) return {};  // a duplicate
  replies_.emplace(command.echo_sample, command);
  const std::uint64_t newest = replies_.rbegin()->first;
  return newest > kMaxReorder ? settle(newest - kMaxReorder) : Result<void>();
}

Result<void> SessionReplay::finish() { return replies_.empty() ? Result<void>() : settle(replies_.rbegin()->first); }

Result<void> SessionReplay::settle(std::uint64_t up_to_sample) {
  while (!replies_.empty() && replies_.begin()->first <= up_to_sample) {
    const ForceCommand command = replies_.begin()->second;
    replies_.erase(replies_.begin());
    if (const auto replayed = step_method(command); !replayed) return replayed;
  }
  return {};
}

// The file of an effect is not in the recording, only its name and its hash.
Result<void> SessionReplay::check_effects(const HapticsSetup& setup) const {
  const std::string_view recorded = effects_in(setup.method.data());
  const std::string text = effects_ != nullptr ? effects_->to_text() : "";
  const std::string_view given = effects_in(text);
  if (recorded.find("!cut") != std::string_view::npos)
    return fail("an effect from a file was cut off in this session ({}), which depends on its timing: it cannot be replayed", recorded);
  if (std::string_view(setup.method.data()).find(" cut=method") != std::string_view::npos)
    return fail("the method from a file was cut off in this session, which depends on its timing: it cannot be replayed");
  if (recorded == given) return {};
  if (recorded.empty()) return fail("the session has no effects from files; leave --effect out");
  return fail(
      "the session has effects from files, {}: name the same files with the same parameters in the same order, --effect "
      "FILE.so:KEY=VALUE,..."
      " (given: {})",
      recorded, given.empty() ? "none" : given);
}

Result<std::unique_ptr<TouchStep>> SessionReplay::make_method_of(const HapticsSetup& setup, double* offset_m) {
  if (parse_tool_text(setup.method.data())) {
    return fail(
        "the stylus held a rigid tool, whose forces depend on when its slow task was done; hapton session export FILE --out DIR "
        "writes the motion (trajectory.csv), and hapton replay --tool follows it");
  }
  if (const auto checked = check_effects(setup); !checked) return tl::unexpected(checked.error());
  const auto settings = parse_method_text(setup.method.data());
  if (!settings) return tl::unexpected(settings.error());
  if (offset_m != nullptr) *offset_m = settings->offset_m;
  return make_touch_(setup);
}

// Begins with another haptics process. Its first step was in free space, unless the recording began after that step.
Result<void> SessionReplay::begin_process(std::uint64_t sender, const ForceCommand& first) {
  sender_ = sender;
  method_serial_ = first.method_serial;
  last_sample_ = 0;
  const auto setup = setups_.find({sender_, method_serial_});
  is_method_known_ = setup != setups_.end();
  const auto any = is_method_known_ ? setup : setups_.lower_bound({sender_, 0});
  if (any == setups_.end() || any->first.first != sender_) {
    return fail("the recording does not name its scene and method; only a session of a haptics node of this version can be replayed");
  }
  setup_ = any->second;
  double offset_m = 0.0;
  auto touch = make_method_of(setup_, &offset_m);
  if (!touch) return tl::unexpected(touch.error());
  material_serial_ = first.material_serial;
  const auto known = find_materials(setup_, material_serial_);
  if (!known) return tl::unexpected(known.error());
  are_materials_known_ = *known;
  if (!materials_.empty()) (*touch)->set_materials(materials_);
  step_ = std::make_unique<HapticsStep>(std::move(*touch), offset_m);
  step_->use_effects(effects_);
  begin_moves(first.move_serial);
  deformed_ = step_->touch().method().list_streamed();
  shape_serial_ = first.shape_serial;
  shapes_.begin(sender_, first.shape_serial);
  are_shapes_known_ = first.shape_serial == 0 || restore_shapes(first.scene_time_ns);
  is_view_known_ = are_carves_known_ = true;
  uncarved_.reset();
  if (const Sculpture* whole = step_->touch().method().sculpture(); whole != nullptr) uncarved_ = *whole;
  if (uncarved_) repeat_carves(first.carve_serial);
  last_busy_ns_ = rebuilt_ns_ = first.echo_sample_time_ns;
  is_certain_ = is_known() && first.replied_before == 0;
  return {};
}

// Objects may have been moved before the recording began. The haptics node sends the newest move of each again: applies those.
void SessionReplay::begin_moves(std::uint32_t serial) {
  are_moves_known_ = true;
  move_serial_ = serial;
  if (serial == 0) return;
  std::set<int> known;
  for (auto move = moves_.lower_bound({sender_, 0, 0}); move != moves_.end(); ++move) {
    const auto& [sender, number, object] = move->first;
    if (sender != sender_ || number > serial) break;
    step_->command(object, to_command(move->second));
    known.insert(object);
  }
  const std::vector<int> all = step_->touch().commanded_objects();
  are_moves_known_ = std::all_of(all.begin(), all.end(), [&](int object) { return known.contains(object); });
}

// The bodies after all carves and undos up to this serial. None: the recording lacks one of these, or a carve does not fit the bodies.
std::optional<Sculpture> SessionReplay::make_shape(std::uint32_t serial) const {
  CarveList list;
  for (std::uint32_t n = 1; n <= serial; ++n) {
    const Carves::One* one = carves_.find(sender_, n);
    if (one == nullptr || !list.add(to_made_carve(*one, n))) return std::nullopt;
  }
  Sculpture shape = *uncarved_;
  bool is_of_these = true;
  list.for_each_active({}, [&](const MadeCarve& made) { is_of_these = is_of_these && carve_body(shape, made); });
  return is_of_these ? std::optional(std::move(shape)) : std::nullopt;
}

// Carves again what was carved before the recording began, or before a step that is unknown. Pre: nothing is carved in step_ yet.
void SessionReplay::repeat_carves(std::uint32_t serial) {
  if (serial == 0) return;
  std::optional<Sculpture> shape = make_shape(serial);
  are_carves_known_ = are_carves_known_ && shape && step_->restore_carves(*shape, serial);
}

// The steps carve by themselves. But an undo between two samples has a serial of its own, which no step makes: this repeats it.
void SessionReplay::undo_carves(std::uint32_t serial, bool is_after_lost) {
  while (uncarved_ && is_certain_ && step_->touch().newest_carve_serial() < serial) {
    const std::uint32_t next = step_->touch().newest_carve_serial() + 1;
    const Carves::One* one = carves_.find(sender_, next);
    if (one != nullptr && !one->is_undo()) return;  // the steps differ from the recorded ones, which their comparison shows
    // If replies were lost, it is unknown before which of their samples the undo was made.
    is_certain_ = one != nullptr && !is_after_lost;
    if (!is_certain_) return;
    std::optional<Sculpture> shape = make_shape(next);
    is_certain_ = shape && step_->restore_carves(*shape, next);
  }
}

bool SessionReplay::has_rested(const ForceCommand& command) const {
  return ns_between(last_busy_ns_, command.echo_sample_time_ns) >= kStatelessAfterNs &&
         ns_between(rebuilt_ns_, command.echo_sample_time_ns) >= kRebuildEveryNs;
}

// In free space a method has no state, so the comparison can begin in such a step. Effects have a state even then: time, velocity.
Result<void> SessionReplay::regain_certainty(const ForceCommand& command) {
  if (is_certain_ || command.contact || step_->has_effects()) return {};
  if (const auto rebuilt = rebuild_surfaces(command); !rebuilt) return rebuilt;
  if (!is_known()) return {};
  if (step_->touch().has_sculpture()) {
    if (!has_rested(command)) return {};
    if (const auto rebuilt = rebuild_bodies(command); !rebuilt) return rebuilt;
  }
  if (!is_known()) return {};
  step_->restart();
  is_certain_ = true;
  return {};
}

// Makes the bodies again. The carves of unknown steps are in the recording too, so they can be repeated.
Result<void> SessionReplay::rebuild_bodies(const ForceCommand& command) {
  auto touch = make_method_of(setups_.at({sender_, method_serial_}));
  if (!touch) return tl::unexpected(touch.error());
  if (!materials_.empty()) (*touch)->set_materials(materials_);
  step_->begin_anew(std::move(*touch));
  rebuilt_ns_ = command.echo_sample_time_ns;
  repeat_carves(command.carve_serial);
  return {};
}

bool SessionReplay::apply_move(std::uint32_t serial) {
  const auto move = moves_.lower_bound({sender_, serial, 0});
  const bool is_there = move != moves_.end() && std::get<0>(move->first) == sender_ && std::get<1>(move->first) == serial;
  return is_there && step_->command(move->second.object, to_command(move->second));
}

// A move has its own start time, so moves can be applied before the samples whose replies were lost are repeated.
void SessionReplay::change_moves(std::uint32_t serial) {
  while (are_moves_known_ && move_serial_ < serial) are_moves_known_ = apply_move(++move_serial_);
  move_serial_ = std::max(move_serial_, serial);
  if (!are_moves_known_) is_certain_ = false;
}

// As in change_moves: a shape has its own start time.
void SessionReplay::change_shapes(std::uint32_t serial) {
  while (are_shapes_known_ && shape_serial_ < serial) {
    are_shapes_known_ = shapes_.apply(sender_, ++shape_serial_, *step_, find_shape());
  }
  if (shape_serial_ < serial) shapes_.skip_to(sender_, serial);
  shape_serial_ = std::max(shape_serial_, serial);
  if (!are_shapes_known_) is_certain_ = false;
}

RecordedShapes::FindShape SessionReplay::find_shape() const {
  return [this](std::int32_t object) { return find_program_shape_ ? find_program_shape_(setup_, object) : nullptr; };
}

// Pre: all surfaces are in their rest shape.
bool SessionReplay::restore_shapes(std::int64_t scene_time_ns) {
  return shapes_.knows(sender_, deformed_, scene_time_ns) && shapes_.restore(sender_, deformed_, scene_time_ns, *step_, find_shape());
}

// Where the surfaces are is known again as soon as the recording has both shapes of a motion, or after its end the last shape alone.
Result<void> SessionReplay::rebuild_surfaces(const ForceCommand& command) {
  if (are_shapes_known_ || !is_method_known_ || !shapes_.knows(sender_, deformed_, command.scene_time_ns)) return {};
  auto touch = make_method_of(setup_);
  if (!touch) return tl::unexpected(touch.error());
  if (!materials_.empty()) (*touch)->set_materials(materials_);
  step_->begin_anew(std::move(*touch));
  are_shapes_known_ = restore_shapes(command.scene_time_ns);
  return {};
}

// Repeats the changes of the method up to this serial. If the recording does not name the method, its forces are unknown. The loop goes
// through the setups in the recording, not through all serials, because a damaged recording may name any serial, even an earlier one.
Result<void> SessionReplay::change_method(std::uint32_t serial) {
  if (serial == method_serial_) return {};
  if (serial < method_serial_) is_certain_ = false;
  std::uint32_t next = serial < method_serial_ ? serial : method_serial_ + 1;
  const auto end = setups_.upper_bound({sender_, serial});
  for (auto setup = setups_.lower_bound({sender_, next}); setup != end; ++setup) {
    if (setup->first.second != next) is_certain_ = false;
    next = setup->first.second + 1;
    // The new method took over with the materials of that moment.
    if (const auto changed = change_materials(setup->second.material_serial); !changed) return changed;
    auto touch = make_method_of(setup->second);
    if (!touch) return tl::unexpected(touch.error());
    if (!materials_.empty()) (*touch)->set_materials(materials_);
    step_->replace(std::move(*touch));
    setup_ = setup->second;
  }
  method_serial_ = serial;
  is_method_known_ = setups_.contains({sender_, serial});
  if (!is_method_known_) is_certain_ = false;
  return {};
}

// False: the recording does not have these materials. Serial 0: the materials are those of the scene.
Result<bool> SessionReplay::find_materials(const HapticsSetup& setup, std::uint32_t serial) {
  materials_.clear();
  if (serial == 0) return true;
  const auto state = material_states_.find({sender_, serial});
  if (state == material_states_.end()) return false;
  auto materials = make_materials_(setup, state->second);
  if (!materials) return tl::unexpected(materials.error());
  materials_ = std::move(*materials);
  return true;
}

// Repeats the changes of the materials up to this serial, as change_method does for the method.
Result<void> SessionReplay::change_materials(std::uint32_t serial) {
  if (serial <= material_serial_) return {};
  std::uint32_t next = material_serial_ + 1;
  const auto end = material_states_.upper_bound({sender_, serial});
  for (auto state = material_states_.lower_bound({sender_, next}); state != end; ++state) {
    if (state->first.second != next) is_certain_ = false;
    next = state->first.second + 1;
    if (const auto found = find_materials(setup_, state->first.second); !found) return tl::unexpected(found.error());
    step_->set_materials(materials_);
  }
  material_serial_ = serial;
  are_materials_known_ = material_states_.contains({sender_, serial});
  if (are_materials_known_) return {};
  materials_.clear();
  is_certain_ = false;
  return {};
}

// A program may use one revision for two poses: then a reply does not tell with which of the two it was computed.
void SessionReplay::change_view(std::uint32_t revision) {
  if (ambiguous_views_.contains(revision)) return lose_view();
  is_view_known_ = true;
  if (revision == step_->view().revision) return;
  if (const auto sent = views_.find(revision); sent != views_.end()) {
    step_->turn_scene(sent->second);
    return;
  }
  for (const auto& [key, setup] : setups_) {
    if (key.first != sender_ || setup.view_revision != revision) continue;
    step_->turn_scene({revision, setup.X_WS});
    return;
  }
  lose_view();
}

void SessionReplay::lose_view() {
  ++counts_.missing_views;
  is_view_known_ = is_certain_ = false;
}

std::optional<ForceCommand> SessionReplay::step(std::uint64_t sample) {
  const auto state = states_.find(sample);
  if (state == states_.end()) {
    ++counts_.missing_states;
    is_certain_ = false;
    return std::nullopt;
  }
  step_->offer(state->second);
  const ForceCommand replayed = step_->reply();
  states_.erase(states_.begin(), std::next(state));
  last_sample_ = sample;
  ++counts_.steps;
  counts_.contact_steps += replayed.contact ? 1 : 0;
  return replayed;
}

// Repeats the steps of the samples before this one that had a reply which was lost.
void SessionReplay::step_lost(const ForceCommand& before) {
  const bool knows_all = before.echo_sample - last_sample_ <= kMaxReorder || last_sample_ == 0;
  if (!knows_all) is_certain_ = false;
  for (std::uint64_t back = kMaxReorder; back > 0; --back) {
    const bool had_reply = (before.replied_before >> (back - 1) & 1U) != 0;
    if (!had_reply || back >= before.echo_sample || before.echo_sample - back <= last_sample_) continue;
    const bool is_before_the_recording = states_.empty() || before.echo_sample - back < states_.begin()->first;
    if (last_sample_ == 0 && is_before_the_recording) continue;
    if (const auto state = states_.find(before.echo_sample - back); last_sample_ == 0 && state != states_.end()) {
      step_->set_scene_time(ns_between(ns_between(state->second.sample_time_ns, before.echo_sample_time_ns), before.scene_time_ns));
    }
    step_->set_thinned(back == kMaxReorder || (before.replied_before >> back) != 0);  // as in step_method
    if (step(before.echo_sample - back)) ++counts_.lost_replies;
  }
}

Result<void> SessionReplay::step_method(const ForceCommand& command) {
  const std::uint64_t lost_before = counts_.lost_replies;
  const bool is_after_unknown = command.echo_sample - last_sample_ > kMaxReorder;
  change_moves(command.move_serial);
  change_shapes(command.shape_serial);
  step_lost(command);
  // It is unknown which of the lost replies was the first with the new method, or with the new materials.
  const bool is_other = command.method_serial != method_serial_ || command.material_serial != material_serial_;
  if (is_other && counts_.lost_replies > lost_before) is_certain_ = false;
  undo_carves(command.carve_serial, counts_.lost_replies > lost_before);
  if (const auto changed = change_method(command.method_serial); !changed) return changed;
  if (const auto changed = change_materials(command.material_serial); !changed) return changed;
  change_view(command.view_revision);
  const bool had_gap = command.replied_before == 0 && last_sample_ != 0;
  if (step_->has_effects() && had_gap) is_certain_ = false;
  // If replied_before is not 0, the probe did not begin anew, even if the haptics node got few states (see HapticsStep::set_thinned).
  step_->set_thinned(command.replied_before != 0);
  const auto state = states_.find(command.echo_sample);
  const bool is_free = !command.contact && state != states_.end() && state->second.buttons == 0;
  if (!is_free || is_after_unknown || counts_.lost_replies > lost_before) last_busy_ns_ = command.echo_sample_time_ns;
  if (const auto found = regain_certainty(command); !found) return found;
  step_->set_scene_time(command.scene_time_ns);
  const auto replayed = step(command.echo_sample);
  if (replayed) compare(command, *replayed);
  return {};
}

void SessionReplay::compare(const ForceCommand& recorded, const ForceCommand& replayed) {
  if (!is_certain_) {
    ++(is_known() ? counts_.not_compared : counts_.unknown_method);
    return;
  }
  ++counts_.compared;
  const bool is_same = recorded.contact == replayed.contact && same_bits(recorded.force_n, replayed.force_n) &&
                       same_bits(recorded.torque_nm, replayed.torque_nm) && same_bits(recorded.visual_offset_m, replayed.visual_offset_m);
  if (is_same) return;
  ++counts_.different;
  counts_.max_difference_n = std::max(counts_.max_difference_n, (recorded.force_n - replayed.force_n).norm());
  if (!counts_.first_difference.empty()) return;
  counts_.first_difference =
      fmt::format("sample {}, {:.6f} s after the first: recorded force {} N, replayed {} N", recorded.echo_sample,
                  seconds_between(first_time_ns_, recorded.echo_sample_time_ns), text_of(recorded.force_n), text_of(replayed.force_n));
}

}  // namespace hapton
