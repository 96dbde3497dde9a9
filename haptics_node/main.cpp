#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/button_bit.h"
#include "core/force/stiffest.h"
#include "core/force/virtual_coupling.h"
#include "haptic_step/haptics_setup.h"
#include "haptic_step/object_mover.h"
#include "haptic_step/scene_facts.h"
#include "haptics_node/grasp_task.h"
#include "haptics_node/haptic_scene.h"
#include "haptics_node/haptics_options.h"
#include "haptics_node/haptics_report.h"
#include "haptics_node/inside_body_warning.h"
#include "haptics_node/object_shaper.h"
#include "haptics_node/placed_scene.h"
#include "haptics_node/preparation_notice.h"
#include "haptics_node/reply_loop.h"
#include "haptics_node/scene_plugins.h"
#include "haptics_node/scene_probe.h"
#include "haptics_node/scene_watcher.h"
#include "haptics_node/tool_task.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"
#include "plugin/plugin_method.h"
#include "runtime/descriptor_check.h"
#include "runtime/instruction_set_check.h"
#include "runtime/log.h"
#include "runtime/standard_streams.h"
#include "scene/find_scene.h"
#include "scene/scene_combination.h"
#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "scene/scene_report.h"
#include "scene/tool_obstacles.h"

namespace {

using namespace hapton;

int give_up(const Error& error) {
  log_error("{}", error.what);
  return 1;
}

// With a connection of its own, so that the one used for forces starts fresh.
void notify_hub(const HapticsOptions& options, const Address& hub, const RoleKey& key, const Clock& clock, const SceneFacts& facts,
                std::int64_t began_ns, DoneSignal& done) {
  const auto endpoint = open_udp_endpoint(options.bind.empty() ? any_address_like(hub) : options.bind);
  if (!endpoint) return;  // run() opens one too, and reports the error
  (void)(*endpoint)->accept_only(hub);
  SealedClient sealed(**endpoint, clock, key, hub);
  HubClient client(sealed, clock, NodeRole::haptics, hub);
  notify_preparation(client, clock, facts, began_ns, done);
}

// Called for the effects of the command line, then for those of the scene.
Result<void> load_effects(const std::vector<PluginChoice>& choices, PluginEffects& effects) {
  for (const PluginChoice& choice : choices) {
    if (const auto added = effects.add(choice); !added) return added;
    log_info("effect {}", choice.to_text());
  }
  return {};
}

// Makes the method that the settings name: a built-in one, or that of the shared library.
Result<std::unique_ptr<ForceMethod>> make_any(const HapticsOptions& options, MethodSettings& settings, const TouchScene& scene,
                                              const Clock& clock) {
  if (!is_plugin_method(settings.name)) return make_built_in(settings, scene);
  if (scene.has_motion()) return fail("method '{}': objects of the scene move; choose method proxy", settings.name);
  if (scene.has_sculpt()) return fail("method '{}': objects of the scene can be carved; choose method proxy", settings.name);
  if (!options.method_file)
    return fail("method '{}': no shared library was given; start haptics_node with --method FILE.so", settings.name);
  auto made = PluginMethod::make(*options.method_file, couple_scene(scene, settings.coupling_n_per_m), clock, options.plugin_budget_ns());
  if (!made) return tl::unexpected(made.error());
  settings.name = (*made)->full_name();
  return std::move(*made);
}

// Explains why the node has never joined the hub.
Error explain_no_hub(JoinState state, const Address& hub, double seconds) {
  if (state == JoinState::rejected) {
    return {fmt::format("the hub at {} had another haptics node for all of {} s; end that one, or give this one more --seconds to wait",
                        to_string(hub), seconds)};
  }
  return {fmt::format("no hub at {} accepted it within {} s; start io_node there, give another address with --hub, or give the hub's --key",
                      to_string(hub), seconds)};
}

// What the node starts with: the scene as loaded from its file, and with the changes saved in the annotations file.
struct StartScene {
  std::filesystem::path path;
  Scene loaded;
  std::vector<PutDown> put_down;
  std::vector<CarvedPress> carved;
  Scene placed;
};

// Loads the scene's own plug-ins as well.
Result<StartScene> load_start_scene(const HapticsOptions& options, PluginEffects& effects) {
  StartScene start;
  start.path = find_scene(options.scene);
  auto loaded = load_scene(start.path, options.loading);
  if (!loaded) return tl::unexpected(loaded.error());
  const auto named = choose_scene_plugins(*loaded, start.path, options.allow_plugins);
  if (!named) return tl::unexpected(named.error());
  if (const auto added = load_effects(*named, effects); !added) return tl::unexpected(added.error());
  auto put_down = read_saved_poses(options.annotations, *loaded);
  if (!put_down) return tl::unexpected(put_down.error());
  auto carved = read_saved_carves(options.annotations, *loaded);
  if (!carved) return tl::unexpected(carved.error());
  start.placed = place_objects(*loaded, *put_down);
  const bool has_tool = !options.tool.file.empty() || start.placed.tool;
  if (const auto checked = check_combination(start.path, start.placed, has_tool); !checked) return tl::unexpected(checked.error());
  std::vector<std::string> tool_notes;
  auto tool = find_tool(options.tool, start.placed, options.loading, tool_notes);
  if (!tool) return tl::unexpected(tool.error());
  for (const auto& note : tool_notes) log_info("tool: {}", note);
  start.placed.tool = std::move(*tool);
  for (const auto& note : start.placed.notes) log_info("{}", note);
  for (const auto& warning : find_inside_out(start.placed)) log_warning("{}", warning);
  start.loaded = std::move(*loaded);
  start.put_down = std::move(*put_down);
  start.carved = std::move(*carved);
  return start;
}

// Lets the stylus pick up the movable objects, if there are any and it holds no tool.
void set_up_grasp(const HapticsOptions& options, const StartScene& start, bool has_tool, GraspLink& link, HapticsStep& step,
                  std::optional<Grasp>& grasp) {
  const auto movable = list_movable(start.placed);
  if (std::find(movable.begin(), movable.end(), true) == movable.end()) return;
  if (has_tool) {
    log_warning("the stylus holds a tool: the movable objects of the scene cannot be picked up");
    return;
  }
  ToolObstacles obstacles = make_tool_obstacles(start.placed.touch_scene());
  step.set_grasp(&grasp.emplace(link, movable, button_bit(options.grasp_button)), std::move(obstacles.parts));
  for (const PutDown& each : start.put_down) grasp->place(each.object, each.pose());
  log_info("button {} of the stylus picks up movable objects while they are touched", options.grasp_button);
  if (obstacles.leaves_out) log_warning("while one is held, {}", kToolLeavesOut);
}

// What carries out changes to objects, by carving and by programs.
struct ObjectChanges {
  ObjectChanges(const Scene& scene, const HapticsStep& step, std::uint32_t source)
      : mover(scene, source), shaper(scene, step.touch(), source) {}

  ObjectMover mover;
  ObjectShaper shaper;
  std::optional<CarveSender> carve_sender;  // this and the next: only if objects of the scene can be carved
  std::optional<CarveUndoTask> carve_undo;
};

// Makes the saved carves again, before the first reply. source: as in Carves.
void restore_carves(const HapticsOptions& options, const std::vector<CarvedPress>& carved, std::uint32_t source, HapticsStep& step,
                    ObjectChanges& changes) {
  const Sculpture* whole = step.touch().method().sculpture();
  if (whole == nullptr) return;
  const Sculpture before = *whole;
  const std::vector<MadeCarve> made = apply_saved_carves(carved, step);
  if (!made.empty()) log_info("{} carves of {} are made again", made.size(), options.annotations.string());
  changes.carve_sender.emplace(source);
  for (const MadeCarve& each : made) changes.carve_sender->note(each);
  changes.carve_undo.emplace(before, made);
}

// Pre: the loop is not running yet.
void use_changes(ObjectChanges& changes, ReplyLoop& loop) {
  loop.set_object_mover(&changes.mover);
  if (changes.shaper.has_objects()) {
    loop.set_object_shaper(&changes.shaper);
    changes.shaper.start();
    log_info("objects that programs may deform: {}", changes.shaper.count());
  }
  if (changes.carve_sender) {
    loop.set_carve_sender(&*changes.carve_sender);
    loop.set_carve_undo(&*changes.carve_undo);
  }
}

// If there is a rigid tool, it is felt in place of the method's probe.
void use_tool(const LiveTool& tool, const TouchScene& scene, HapticsStep& step, HapticsSetup& setup, std::optional<ToolTask>& task) {
  if (!tool) return;
  step.hold(tool.felt.get(), make_tool_obstacles(scene).parts);
  setup.method = tool.describe(tool.coupling.stiffness_n_per_m);
  if (tool.followed != nullptr) task.emplace(*tool.followed);
}

// The largest gains of the tool; without a tool those of the probe, or of probe and picked-up objects if objects can be picked up.
LargestGains find_felt_gains(const LiveTool& tool, bool picks_up, const TouchScene& scene) {
  if (tool) return find_gains(tool, scene);
  return picks_up ? find_largest_gains(scene).largest_of(find_tool_gains(scene)) : find_largest_gains(scene);
}

GraspTask::Options make_grasp_options(const HapticsOptions& options, HapticScene& felt, StiffnessAdviser& adviser) {
  return {.coupling_n_per_m = options.method.coupling_n_per_m,
          .rotational_stiffness_nm_per_rad = options.tool_nm_per_rad,
          .threads = options.tool_threads,
          .shading_crease_rad = options.shading_crease_rad(),
          .on_scene = [&felt](const TouchScene& now, std::uint32_t revision) { felt.place(now, revision); },
          .on_tool = [&adviser](const ToolCoupling& held) { adviser.note_tool(held.rotational_stiffness_nm_per_rad); }};
}

SceneWatcher::Options make_watcher_options(const HapticsOptions& options, const StartScene& start, bool has_tool, HapticScene& felt) {
  return {.path = start.path,
          .loading = options.loading,
          .coupling_n_per_m = options.method.coupling_n_per_m,
          .has_tool = has_tool,
          .on_scene = [&felt](const TouchScene& now) { felt.follow(now); }};
}

Result<void> enter_realtime_and_log(const RealtimeSettings& settings) {
  const auto realtime = enter_realtime(settings);
  if (!realtime) return tl::unexpected(realtime.error());
  const auto lines = realtime->to_lines();
  log_info("{}", lines.front());
  for (std::size_t n = 1; n < lines.size(); ++n) log_warning("{}", lines[n]);
  return {};
}

void print_shapes(const ObjectShaper& shaper) {
  if (!shaper.has_objects()) return;
  const ObjectShaper::Counts& counts = shaper.counts();
  print_text("shapes from programs: {} taken, {} left out as a part was lost or late, {} parts or shapes rejected\n", counts.shapes,
             counts.incomplete, counts.rejected);
}

// Ends the slow tasks first, so that their times are complete.
void stop_and_print(std::optional<ToolTask>& tool_task, const LiveTool& tool, std::optional<GraspTask>& grasp_task) {
  if (tool_task) {
    tool_task->stop();
    print_text("{}", describe_times("pose of the tool", tool_task->pose_times()));
    if (const std::string late = describe_late_tool(tool.followed->lateness()); !late.empty()) log_warning("{}", late);
  }
  if (grasp_task) {
    grasp_task->stop();
    if (grasp_task->pose_times().count() > 0) print_text("{}", describe_times("pose of held objects", grasp_task->pose_times()));
  }
}

// What the node is made of before it replies. All of it outlives the loop.
struct NodeParts {
  const HapticsOptions& options;
  const StopSignal& stop;
  const Clock& clock;
  const Address& hub;
  HubClient& client;
  PluginEffects& effects;
  const StartScene& start;
  const SceneFacts& facts;
  const LiveTool& tool;
  const MakeMethod& make;
  const MethodSettings& settings;  // of the method in use, with its full name
};

void print_report(const NodeParts& node, const HapticsStep& step, const ReplyLoop& loop, const ObjectShaper& shaper) {
  print_text("{}", make_haptics_report(step, node.client, loop.compute_times(), loop.step_times()));
  print_text("{}", describe_spins(loop.wait()));
  print_shapes(shaper);
  print_text("{}", node.effects.describe());
}

// Replies to the hub until it is time to stop, then prints the report.
Result<void> serve(const NodeParts& node, std::unique_ptr<ForceMethod> method) {
  const HapticsOptions& options = node.options;
  const LiveTool& tool = node.tool;
  const Scene& scene = node.start.placed;
  const bool has_effects = !node.effects.empty();
  HapticsStep step(std::make_unique<TouchStep>(std::move(method), scene.touch_scene()), options.method.offset_m);
  if (has_effects) step.use_effects(&node.effects);
  MethodBuilder builder(options.method, scene.touch_scene(), step.touch().share_method(), node.make);
  HapticsSetup setup = make_haptics_setup(node.start.path, options.loading, hash_scene(scene.touch_scene()), node.settings);
  std::optional<ToolTask> tool_task;
  use_tool(tool, scene.touch_scene(), step, setup, tool_task);
  // Made before the loop, which uses them.
  GraspLink grasp_link;
  std::optional<Grasp> grasp;
  set_up_grasp(options, node.start, tool.felt != nullptr, grasp_link, step, grasp);
  const TouchScene first_felt_scene = couple_scene(scene.touch_scene(), options.method.coupling_n_per_m);
  PatchSender patches(first_felt_scene, options.method.probe_radius_m, setup.scene_hash,
                      !has_effects && PatchSender::can_offer({setup.method.data(), setup.method.size()}),
                      {.bits_per_s = 1e6 * options.patch_mbit_per_s});
  ReplyLoop loop(node.client, node.clock, step, builder, setup, options.method.build_on_approach, node.facts);
  loop.set_patch_sender(&patches);
  if (has_effects) loop.set_effects(&node.effects);
  loop.set_longest_spin(std::llround(1e3 * options.spin_us));
  const auto gains_of = [&](const TouchScene& touched) { return find_felt_gains(tool, grasp.has_value(), touched); };
  StiffnessAdviser adviser(gains_of(first_felt_scene));
  loop.set_stiffness_adviser(&adviser);
  InsideBodyWarning inside(first_felt_scene);
  loop.set_inside_body_warning(&inside);
  HapticScene felt(first_felt_scene, gains_of, adviser, inside, patches);
  MaterialTask::DescribeTool describe_tool;
  if (tool) describe_tool = [&](double stiffness_n_per_m) { return tool.describe(stiffness_n_per_m); };
  MaterialTask material_task(
      scene, options.method.coupling_n_per_m, [&](const std::vector<Material>& materials) { felt.tune(materials); }, describe_tool);
  loop.set_material_task(&material_task);
  const auto source = static_cast<std::uint32_t>(make_random_id()) | 1U;
  ObjectChanges changes(scene, step, source);
  restore_carves(options, node.start.carved, source, step, changes);
  use_changes(changes, loop);
  SceneWatcher watcher(make_watcher_options(options, node.start, tool.felt != nullptr, felt),
                       options.watch_scene ? node.start.loaded : Scene(), material_task, builder);
  if (options.watch_scene) watcher.start();
  std::optional<GraspTask> grasp_task;
  if (grasp) {
    grasp_task.emplace(make_grasp_options(options, felt, adviser), node.start.loaded, node.start.put_down, grasp_link, material_task,
                       builder, node.clock);
    grasp_task->start();
  }
  if (const auto entered = enter_realtime_and_log(options.realtime); !entered) return entered;
  print_text("ready for the hub at {}\n", to_string(node.hub));
  std::fflush(stdout);

  loop.run(node.stop, options.seconds);
  node.client.leave();  // the reports take longer than the hub waits for a force
  print_report(node, step, loop, changes.shaper);
  stop_and_print(tool_task, tool, grasp_task);
  return {};
}

int run(const HapticsOptions& options) {
  const StopSignal stop;  // first, so that a signal ends the program properly at any point
  const auto hub = parse_address(options.hub);
  if (!hub) return give_up(hub.error());
  const auto key = find_role_key(options.key_file, *hub, KeyRole::haptics);
  if (!key) return give_up(key.error());
  const SteadyClock clock;
  PluginEffects effects(clock, options.plugin_budget_ns());
  if (const auto loaded = load_effects(options.effects, effects); !loaded) return give_up(loaded.error());
  const auto start = load_start_scene(options, effects);
  if (!start) return give_up(start.error());
  const SceneFacts facts = make_scene_facts(start->placed);
  const MakeMethod make = [&](MethodSettings& settings, const TouchScene& touched) { return make_any(options, settings, touched, clock); };
  MethodSettings settings = options.method;
  auto method =
      build_and_notify([&] { return make(settings, start->placed.touch_scene()); },
                       [&, began_ns = clock.now_ns()](DoneSignal& done) { notify_hub(options, *hub, *key, clock, facts, began_ns, done); });
  if (!method) return give_up(method.error());
  if (!start->placed.tool) log_method(**method);  // with a tool, the method is not felt
  const auto tool = make_live_tool(options, start->placed);
  if (!tool) return give_up(tool.error());
  auto endpoint = open_udp_endpoint(options.bind.empty() ? any_address_like(*hub) : options.bind);
  if (!endpoint) return give_up(endpoint.error());
  // Other senders are dropped early, so that a flood at this port costs no time. If this fails, each datagram costs one check.
  (void)(*endpoint)->accept_only(*hub);

  SealedClient::Options sealing;
  sealing.worker = AgreementWorker::Where::own_thread;
  SealedClient sealed(**endpoint, clock, *key, *hub, sealing);
  HubClient client(sealed, clock, NodeRole::haptics, *hub);
  const auto served = serve({.options = options,
                             .stop = stop,
                             .clock = clock,
                             .hub = *hub,
                             .client = client,
                             .effects = effects,
                             .start = *start,
                             .facts = facts,
                             .tool = *tool,
                             .make = make,
                             .settings = settings},
                            std::move(*method));
  if (!served) return give_up(served.error());
  if (options.seconds > 0.0 && client.counts().joins == 0 && !stop.stop_requested()) {
    return give_up(explain_no_hub(client.state(), *hub, options.seconds));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  outlive_readers();
  check_cpu("haptics_node");
  check_descriptors("haptics_node");
  start_log("haptics_node");
  auto parsed = parse_haptics_options(argc, argv);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  auto& options = std::get<HapticsOptions>(parsed);
  if (const auto taken = take_scene_probe(options); !taken) {
    log_error("{}", taken.error().what);
    return 2;
  }
  return run(options);
}
