#include "tools/check/scene_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "closed_loop/device_model.h"
#include "tools/check/loop_check.h"
#include "tools/check/place_check.h"
#include "tools/check/reach_check.h"
#include "tools/check/sculpt_check.h"
#include "tools/check/surface_check.h"
#include "tools/check/tool_check.h"

namespace hapton {
namespace {

void append(CheckFindings more, CheckFindings& all) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

// Each device whose workspace is known, once. A note names each of the others.
std::vector<const DevicePreset*> known_workspaces(const std::vector<NamedLoop>& loops, std::vector<std::string>& notes) {
  std::vector<const DevicePreset*> known;
  std::string last_device;
  for (const NamedLoop& loop : loops) {
    if (loop.device == last_device) continue;
    last_device = loop.device;
    const DevicePreset* preset = find_device_preset(loop.device);
    if (preset != nullptr && preset->is_workspace_known) {
      known.push_back(preset);
    } else {
      notes.push_back(fmt::format("not checked: whether {} reaches the scene; its workspace is not known here", loop.device));
    }
  }
  return known;
}

// Findings that the object accepts become notes. A fault that it accepts but that was not found gets a note, too.
void split_findings(const SceneObject& object, const SceneCheckSettings& settings, CheckFindings found, SceneCheck& check) {
  const auto accepts = settings.accepted.find(object.line);
  const std::vector<std::string> names = accepts == settings.accepted.end() ? std::vector<std::string>() : accepts->second;
  for (const std::string& name : names) {
    const auto accepted_begin =
        std::stable_partition(found.begin(), found.end(), [&](const CheckFinding& one) { return name_of(one.fault) != name; });
    if (accepted_begin == found.end()) {
      check.notes.push_back(fmt::format("object '{}' accepts '{}', which was not found for this probe", object.name, name));
    }
    for (auto one = accepted_begin; one != found.end(); ++one) {
      check.notes.push_back(fmt::format("accepted: object '{}': {}", object.name, one->what));
      check.accepted.push_back(std::move(*one));
    }
    found.erase(accepted_begin, found.end());
  }
  append(std::move(found), check.findings);
}

std::string location_text(const SceneCheck& check, const CheckFinding& finding) {
  std::string text = check.path + ":";
  if (!finding.object.empty()) text += fmt::format(" object '{}'", finding.object);
  if (finding.place_m) {
    const Vec3& p = *finding.place_m;
    text += fmt::format(" at ({:.4g}, {:.4g}, {:.4g}) m", p.x(), p.y(), p.z());
  }
  return text.ends_with(':') ? text : text + ":";
}

std::string count_text(std::size_t count, std::string_view what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

std::string describe(const StepCost& cost, double rate_hz) {
  return fmt::format(
      "a step takes {:.3g} us at p99, {:.3g} us at most, in {} steps (shortest time of several runs, on this machine); a cycle takes {:g} "
      "us",
      1e-3 * static_cast<double>(cost.p99_ns), 1e-3 * static_cast<double>(cost.worst_ns), cost.steps, 1e6 / rate_hz);
}

}  // namespace

Result<SceneCheck> check_scene(const std::string& path, const Scene& scene, const SceneCheckSettings& settings) {
  SceneCheck check{
      .path = path, .findings = {}, .accepted = {}, .notes = scene.notes, .objects = scene.objects.size(), .triangles = 0, .cost = {}};
  const SafeGains gains = find_safe_gains(settings.loops, settings.rate_hz, settings.delay_s);
  if (scene.tool)
    check.notes.push_back(fmt::format(
        "not checked: where the tool '{}' gets; other findings but those on damping and turning are for a probe", scene.tool->name));
  if (scene.touch_scene().has_motion()) {
    check.notes.emplace_back(
        "checked at rest only: objects that move or deform are not followed, but whether the workspace reaches their keyframes");
  }
  if (scene.touch_scene().has_sculpt()) check.notes.emplace_back("checked as it is before it is carved");
  const bool is_touched_by_tool =
      scene.tool || std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& object) { return object.is_movable; });
  const std::vector<const DevicePreset*> devices = known_workspaces(settings.loops, check.notes);
  const CheckFindings places = check_places(scene);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    check.triangles += object.mesh->triangles.size();
    CheckFindings found = check_surface(object, settings.probe_radius_m);
    std::copy_if(places.begin(), places.end(), std::back_inserter(found),
                 [&](const CheckFinding& place) { return place.object_index == i; });
    append(check_friction(object), found);
    append(check_inertia(object), found);
    append(check_sculpt(object), found);
    append(check_softness(object, settings.loops), found);
    append(check_stiffness(object, gains, settings.rate_hz, settings.delay_s), found);
    append(check_damping(object, gains, settings.rate_hz, settings.delay_s, is_touched_by_tool), found);
    append(check_strength(object, settings.loops), found);
    append(check_frequency(object, settings.rate_hz), found);
    for (const DevicePreset* device : devices) append(check_reach(object, *device), found);
    split_findings(object, settings, std::move(found), check);
  }
  std::copy_if(places.begin(), places.end(), std::back_inserter(check.findings),
               [](const CheckFinding& place) { return !place.object_index; });
  for (const SceneEffect& effect : scene.effects) {
    append(check_stiffness(effect, gains, settings.rate_hz, settings.delay_s), check.findings);
    append(check_damping(effect, gains, settings.rate_hz, settings.delay_s), check.findings);
    append(check_mass(effect, settings.loops, settings.rate_hz, settings.delay_s), check.findings);
    append(check_strength(effect, settings.loops), check.findings);
    append(check_frequency(effect, settings.rate_hz), check.findings);
    for (const DevicePreset* device : devices) append(check_reach(effect, *device), check.findings);
  }
  auto tool = check_tool(scene);
  if (!tool) return tl::unexpected(Error{fmt::format("{}: {}", path, tool.error().what)});
  append(std::move(*tool), check.findings);
  for (const RotationalStiffness& body : list_rotational_stiffness(scene))
    append(check_turning(body.name, body.nm_per_rad, gains, settings.rate_hz, settings.delay_s), check.findings);
  for (const DevicePreset* device : devices) append(check_size(scene, *device), check.findings);
  auto cost = measure_step_cost(scene, {.probe_radius_m = settings.probe_radius_m, .rate_hz = settings.rate_hz, .seed = settings.seed});
  if (!cost) return tl::unexpected(Error{fmt::format("{}: {}", path, cost.error().what)});
  check.cost = std::move(*cost);
  append(check_cost(check.cost, settings.rate_hz), check.findings);
  return check;
}

std::string to_text(const SceneCheck& check, const SceneCheckSettings& settings) {
  std::string text;
  for (const CheckFinding& finding : check.findings)
    text += fmt::format("{} {}; {}\n", location_text(check, finding), finding.what, finding.fix);
  for (const std::string& note : check.notes) text += fmt::format("note: {}\n", note);
  text += fmt::format("{}: {} in {}, {}; {} (seed {})\n", check.path,
                      check.findings.empty() ? "nothing found" : count_text(check.findings.size(), "finding"),
                      count_text(check.objects, "object"), count_text(check.triangles, "triangle"), describe(check.cost, settings.rate_hz),
                      settings.seed);
  return text;
}

std::string to_json(const SceneCheck& check, const SceneCheckSettings& settings) {
  using Json = nlohmann::ordered_json;
  const auto point = [](const Vec3& p) { return Json::array({p.x(), p.y(), p.z()}); };
  const auto to_list = [&](const CheckFindings& all) {
    Json list = Json::array();
    for (const CheckFinding& finding : all) {
      list.push_back({{"fault", name_of(finding.fault)},
                      {"object", finding.object},
                      {"place_m", finding.place_m ? point(*finding.place_m) : Json()},
                      {"what", finding.what},
                      {"fix", finding.fix}});
    }
    return list;
  };
  Json loops = Json::array();
  for (const NamedLoop& loop : settings.loops) loops.push_back({{"device", loop.device}, {"hand", loop.hand}});
  const Json json = {{"schema", "hapton.scene_check/2"},
                     {"file", check.path},
                     {"loops", loops},
                     {"rate_hz", settings.rate_hz},
                     {"delay_ms", 1e3 * settings.delay_s},
                     {"probe_radius_m", settings.probe_radius_m},
                     {"seed", settings.seed},
                     {"objects", check.objects},
                     {"triangles", check.triangles},
                     {"findings", to_list(check.findings)},
                     {"accepted", to_list(check.accepted)},
                     {"step",
                      {{"steps", check.cost.steps},
                       {"p99_ns", check.cost.p99_ns},
                       {"worst_ns", check.cost.worst_ns},
                       {"worst_object", check.cost.worst_object},
                       {"worst_at_m", point(check.cost.worst_at_m)}}},
                     {"notes", check.notes}};
  // Names come from the file and need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace hapton
