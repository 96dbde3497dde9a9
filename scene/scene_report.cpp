#include "scene/scene_report.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <bit>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/effects/texture_models.h"
#include "core/geometry/mesh_measures.h"
#include "scene/mesh_counts_json.h"
#include "scene/scene_layout.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

std::string_view name_of(Passivity passivity) {
  switch (passivity) {
    case Passivity::conservative:
      return "conservative";
    case Passivity::dissipative:
      return "dissipative";
    case Passivity::active:
      return "active";
  }
  return "";
}

Passivity passivity_of(const SceneEffect& effect) { return SwitchedEffect(effect.effect, effect.on).passivity(); }

// The number of the button that switches the effect, counted from 1. Pre: it has a button.
int button_number(const SceneEffect& effect) { return 1 + std::countr_zero(effect.on.button); }

std::vector<std::string> names_of(const SurfaceEffects& effects) {
  std::vector<std::string> names;
  if (effects.progressive.is_on()) names.emplace_back("progressive stiffness");
  if (effects.layers.is_on()) names.push_back(fmt::format("{} layer{}", effects.layers.count(), effects.layers.count() == 1 ? "" : "s"));
  if (effects.bumps.is_on()) names.emplace_back("bumps");
  if (effects.maps.height.is_on()) {
    names.push_back(fmt::format("bumps from an image (slope at most {:.3g})", effects.maps.height.steepest(*effects.maps.triangles)));
  }
  if (effects.maps.stiffness.is_on()) names.emplace_back("stiffness from an image");
  if (effects.maps.friction.is_on()) names.emplace_back("friction from an image");
  if (effects.maps.viscosity.is_on()) names.emplace_back("viscosity from an image");
  if (effects.viscosity.is_on()) names.emplace_back("viscosity");
  if (effects.snap.is_on()) names.emplace_back("snap");
  if (effects.tap.is_on()) names.emplace_back("vibration on tap");
  if (effects.texture.is_on()) {
    const double loudest_n = effects.texture.mass_kg * effects.texture.models->loudest_m_per_s2();
    names.push_back(fmt::format("recorded texture ({} models of {:g} Hz, at most {:.3g} N root mean square)",
                                effects.texture.models->models().size(), effects.texture.models->rate_hz(), loudest_n));
  }
  return names;
}

std::string describe_motion(const KeyframeMotion& motion) {
  return fmt::format("moves by {} keyframes, {:g} s{}", motion.keyframes().size(), motion.duration_s(), motion.loops() ? ", repeated" : "");
}

std::string describe_deformation(const MeshDeformation& deformation) {
  return fmt::format("deforms by {} morph{}, {:g} s{}: {} vertices move", deformation.targets().size(),
                     deformation.targets().size() == 1 ? "" : "s", deformation.duration_s(), deformation.loops() ? ", repeated" : "",
                     deformation.moved().size());
}

std::string describe_sculpt(const SculptSettings& sculpt) {
  return fmt::format("can be carved by button {}: ball of {:.3g} mm radius, voxels of {:.3g} mm", 1 + std::countr_zero(sculpt.button),
                     1e3 * sculpt.tool_radius_m, 1e3 * sculpt.voxel_m);
}

// What moves or deforms the object in a running session: the stylus, or programs.
std::string describe_mover(const SceneObject& object) {
  if (object.is_movable) return ", movable";
  if (object.program_shape != nullptr) {
    return fmt::format(", deformed by programs: {} vertices, reach {:.4g} m", object.mesh->vertices.size(), object.program_shape->reach_m);
  }
  if (object.commanded == nullptr) return "";
  return object.mass_kg > 0.0 ? fmt::format(", moved by programs, mass {:g} kg", object.mass_kg) : ", moved by programs";
}

std::string describe(const Vec3& p) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z()); }

std::string describe(const Similarity& workspace) {
  const Eigen::AngleAxisd turn(workspace.q);
  std::string text = fmt::format("workspace: its middle is {} m in the scene", describe(workspace.p));
  const double degrees = turn.angle() * 180.0 / std::numbers::pi;
  if (degrees > 1e-9) text += fmt::format(", turned by {:.4g} degrees about {}", degrees, describe(turn.axis()));
  return text + fmt::format("; a metre of the hand is {:.4g} m of the scene\n", workspace.scale);
}

std::string describe(const SceneCamera& camera) {
  return fmt::format("camera: from {} m to {} m, up {}, {:.4g} degrees\n", describe(camera.p_WE), describe(camera.p_WC),
                     describe(camera.up), camera.view_angle_deg);
}

std::string describe(const SceneLight& light) {
  const std::string where = light.has_position ? fmt::format("at {} m", describe(light.towards_or_p_W))
                                               : fmt::format("shines along {}", describe(Vec3(-light.towards_or_p_W)));
  return fmt::format("light: {}, colour times intensity {}\n", where, describe(light.colour));
}

std::string describe(const SceneTool& tool) {
  const MeshBounds box = compute_bounds(*tool.mesh);
  const Vec3 size = box.high - box.low;
  return fmt::format("tool {}: {} triangles, {:.4g} x {:.4g} x {:.4g} m around {} from the grip point\n", tool.name,
                     tool.mesh->triangles.size(), size.x(), size.y(), size.z(), describe(box.centre()));
}

// Describes fit or workspace, groups, instances, probes, camera, lights and the tool.
std::string describe_setting(const SceneReport& report) {
  const SceneLayout& layout = *report.layout;
  std::string text;
  if (layout.fit_m)
    text += fmt::format("fit_m: scene scaled by {1:.4g} to fit into {0} m\n", describe(*layout.fit_m), report.scene.fit_scale);
  if (layout.workspace) text += describe(*layout.workspace);
  const auto in_group = [](const GroupSpec& spec) { return spec.group.empty() ? std::string() : ", in group " + spec.group; };
  for (const GroupSpec& group : layout.groups) text += fmt::format("group {}{}\n", group.name, in_group(group));
  for (const GroupSpec& instance : layout.instances)
    text += fmt::format("instance {}: of {}{}\n", instance.name, instance.of, in_group(instance));
  for (const ProbeSpec& probe : layout.probes) text += describe(probe) + "\n";
  if (report.scene.view.camera) text += describe(*report.scene.view.camera);
  for (const SceneLight& light : report.scene.view.lights) text += describe(light);
  if (report.scene.tool) text += describe(*report.scene.tool);
  return text;
}

using InfoJson = nlohmann::ordered_json;

InfoJson to_array(const Vec3& p) { return InfoJson::array({p.x(), p.y(), p.z()}); }

InfoJson to_json(const Similarity& workspace) {
  const Quat& q = workspace.q;
  return {{"center_m", to_array(workspace.p)}, {"rotation", InfoJson::array({q.w(), q.x(), q.y(), q.z()})}, {"scale", workspace.scale}};
}

InfoJson to_json(const SceneCamera& camera) {
  return {{"position_m", to_array(camera.p_WE)},
          {"look_at_m", to_array(camera.p_WC)},
          {"up", to_array(camera.up)},
          {"view_angle_deg", camera.view_angle_deg}};
}

// "color" is the colour times the intensity.
InfoJson to_json(const SceneLight& light) {
  InfoJson json;
  json[light.has_position ? "position_m" : "direction"] = to_array(light.has_position ? light.towards_or_p_W : Vec3(-light.towards_or_p_W));
  json["color"] = to_array(light.colour);
  return json;
}

InfoJson to_json(const GroupSpec& spec) {
  InfoJson json = {{"name", spec.name}};
  if (!spec.of.empty()) json["of"] = spec.of;
  json["group"] = spec.group.empty() ? InfoJson() : InfoJson(spec.group);
  return json;
}

InfoJson to_json(const ProbeSpec& probe) {
  return {{"name", probe.name},
          {"radius_m", probe.radius_m ? InfoJson(*probe.radius_m) : InfoJson()},
          {"method", probe.method ? InfoJson(*probe.method) : InfoJson()},
          {"shading", probe.shading ? InfoJson(*probe.shading) : InfoJson()}};
}

template <class Spec>
InfoJson to_list(const std::vector<Spec>& specs) {
  InfoJson list = InfoJson::array();
  for (const Spec& spec : specs) list.push_back(to_json(spec));
  return list;
}

InfoJson sealing_to_json(const SealReport& sealed) {
  InfoJson json;
  append_sealing(json, sealed);
  json["boundary_edges"] = sealed.boundary_edges;
  json["boundary_edges_left"] = sealed.boundary_edges_left;
  json["unsealed_edges"] = sealed.unsealed_edges;
  json["widest_unsealed_m"] = sealed.widest_unsealed;
  return json;
}

InfoJson mesh_to_json(const SceneObject& object, const MeshFlaws& flaws) {
  InfoJson json = {{"name", object.name},
                   {"triangles", flaws.topology.triangles},
                   {"vertices", flaws.topology.vertices},
                   {"closed", flaws.topology.is_closed()},
                   {"sealed", sealing_to_json(object.sealed)}};
  append_boundary(json, flaws.borders);
  json["closed_bodies"] = flaws.bodies.count;
  json["bodies_inside_out"] = flaws.bodies.inside_out;
  append_flaws(json, flaws);
  json["authored_normals"] = flaws.normals.given;
  json["authored_normals_used"] = flaws.normals.used;
  json["lowest_m"] = to_array(flaws.topology.lowest);
  json["highest_m"] = to_array(flaws.topology.highest);
  return json;
}

InfoJson object_to_json(const SceneReport& report, std::size_t i) {
  const SceneObject& object = report.scene.objects[i];
  InfoJson json = mesh_to_json(object, report.flaws[i]);
  json.update(InfoJson{{"stiffness_n_per_m", object.material.stiffness_n_per_m},
                       {"damping_ns_per_m", object.material.damping_ns_per_m},
                       {"friction_static", object.material.friction_static},
                       {"friction_dynamic", object.material.friction_dynamic},
                       {"two_sided", object.material.two_sided},
                       {"movable", object.is_movable},
                       {"moved_by", object.commanded != nullptr ? InfoJson("program") : InfoJson()},
                       {"deformed_by", object.program_shape != nullptr ? InfoJson("program") : InfoJson()},
                       {"reach_m", object.program_shape != nullptr ? InfoJson(object.program_shape->reach_m) : InfoJson()},
                       {"mass_kg", object.mass_kg > 0.0 ? InfoJson(object.mass_kg) : InfoJson()},
                       {"keyframes", object.motion != nullptr ? object.motion->keyframes().size() : std::size_t{0}},
                       {"motion_s", object.motion != nullptr ? object.motion->duration_s() : 0.0},
                       {"morphs", object.deformation != nullptr ? object.deformation->targets().size() : std::size_t{0}},
                       {"deformation_s", object.deformation != nullptr ? object.deformation->duration_s() : 0.0},
                       {"voxel_m", object.sculpt ? InfoJson(object.sculpt->voxel_m) : InfoJson()},
                       {"tool_radius_m", object.sculpt ? InfoJson(object.sculpt->tool_radius_m) : InfoJson()},
                       {"carve_button", object.sculpt ? InfoJson(1 + std::countr_zero(object.sculpt->button)) : InfoJson()},
                       {"effects", names_of(object.effects)}});
  return json;
}

}  // namespace

Result<SceneReport> make_scene_report(const std::filesystem::path& path) {
  Result<Scene> scene = load_scene(path);
  if (!scene) return tl::unexpected(scene.error());
  auto layout = read_layout(path);
  if (!layout) return tl::unexpected(layout.error());
  SceneReport report{
      .path = path.string(), .scene = std::move(*scene), .flaws = {}, .layout = std::make_shared<const SceneLayout>(std::move(*layout))};
  for (const SceneObject& object : report.scene.objects) report.flaws.push_back(find_flaws(*object.mesh));
  return report;
}

std::vector<std::string> find_inside_out(const Scene& scene) {
  std::vector<std::string> lines;
  for (const SceneObject& object : scene.objects) {
    const std::string line = describe_inside_out(count_closed_bodies(*object.mesh));
    if (!line.empty()) lines.push_back(printable(object.name, kLongestShownName) + ": " + line);
  }
  return lines;
}

std::string to_text(const SceneReport& report) {
  std::string text =
      fmt::format("scene {}, {} object{}\n", report.path, report.scene.objects.size(), report.scene.objects.size() == 1 ? "" : "s");
  for (std::size_t i = 0; i < report.flaws.size(); ++i) {
    const SceneObject& object = report.scene.objects[i];
    const MeshTopology& t = report.flaws[i].topology;
    const Vec3 size = t.highest - t.lowest;
    const Vec3 middle = 0.5 * (t.lowest + t.highest);
    fmt::format_to(std::back_inserter(text),
                   "{:<20} {:>8} triangles, {:.4g} x {:.4g} x {:.4g} m around ({:.4g}, {:.4g}, {:.4g}), {:.6g} N/m, friction {:.3g} / "
                   "{:.3g}{}\n{:<20} {}\n",
                   printable(object.name, kLongestShownName), t.triangles, size.x(), size.y(), size.z(), middle.x(), middle.y(), middle.z(),
                   object.material.stiffness_n_per_m, object.material.friction_static, object.material.friction_dynamic,
                   describe_mover(object), "", to_text(report.flaws[i]));
    if (const auto effects = names_of(object.effects); !effects.empty()) {
      fmt::format_to(std::back_inserter(text), "{:<20} effects: {}\n", "", fmt::join(effects, ", "));
    }
    if (object.motion != nullptr) fmt::format_to(std::back_inserter(text), "{:<20} {}\n", "", describe_motion(*object.motion));
    if (object.deformation != nullptr)
      fmt::format_to(std::back_inserter(text), "{:<20} {}\n", "", describe_deformation(*object.deformation));
    if (object.sculpt) fmt::format_to(std::back_inserter(text), "{:<20} {}\n", "", describe_sculpt(*object.sculpt));
    if (object.sealed.is_worth_a_note()) fmt::format_to(std::back_inserter(text), "{:<20} {}\n", "", object.sealed.describe());
  }
  for (const SceneEffect& effect : report.scene.effects) {
    fmt::format_to(std::back_inserter(text), "effect {}: {}, at most {:.3g} N{}\n", effect.name, name_of(passivity_of(effect)),
                   bound_of(effect.effect), effect.on.button == 0 ? "" : fmt::format(", by button {}", button_number(effect)));
  }
  text += describe_setting(report);
  for (const std::string& note : report.scene.notes) text += "note: " + note + "\n";
  return text;
}

std::string to_json(const SceneReport& report) {
  InfoJson objects = InfoJson::array();
  for (std::size_t i = 0; i < report.flaws.size(); ++i) objects.push_back(object_to_json(report, i));
  InfoJson effects = InfoJson::array();
  for (const SceneEffect& effect : report.scene.effects) {
    effects.push_back({{"name", effect.name}, {"passivity", name_of(passivity_of(effect))}, {"bound_n", bound_of(effect.effect)}});
    if (effect.on.button != 0) effects.back()["button"] = button_number(effect);
  }
  InfoJson plugins = InfoJson::array();
  for (const LibraryEffect& one : report.scene.libraries) plugins.push_back({{"name", one.name}, {"library", one.library.string()}});
  const Scene& scene = report.scene;
  const SceneLayout& layout = *report.layout;
  const InfoJson json = {{"schema", "hapton.scene_info/2"},
                         {"file", report.path},
                         {"objects", objects},
                         {"effects", effects},
                         {"plugins", plugins},
                         {"fit_m", layout.fit_m ? to_array(*layout.fit_m) : InfoJson()},
                         {"fit_scale", scene.fit_scale},
                         {"workspace", layout.workspace ? to_json(*layout.workspace) : InfoJson()},
                         {"groups", to_list(layout.groups)},
                         {"instances", to_list(layout.instances)},
                         {"probes", to_list(layout.probes)},
                         {"camera", scene.view.camera ? to_json(*scene.view.camera) : InfoJson()},
                         {"lights", to_list(scene.view.lights)},
                         {"tool", scene.tool ? InfoJson(scene.tool->name) : InfoJson()},
                         {"notes", scene.notes}};
  return json.dump(2, ' ', false, InfoJson::error_handler_t::replace) + "\n";
}

}  // namespace hapton
