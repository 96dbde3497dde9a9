#include "scene/scene_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/base/similar_word.h"
#include "scene/animated_object.h"
#include "scene/effect_reader.h"
#include "scene/file_bytes.h"
#include "scene/map_reader.h"
#include "scene/material_reader.h"
#include "scene/mesh_cache.h"
#include "scene/mesh_file.h"
#include "scene/misplaced_key.h"
#include "scene/object_deformation.h"
#include "scene/object_motion.h"
#include "scene/object_reader.h"
#include "scene/posed_mesh.h"
#include "scene/probe_tables.h"
#include "scene/scene_fit.h"
#include "scene/scene_hash.h"
#include "scene/scene_objects.h"
#include "scene/table_reader.h"
#include "scene/text_cursor.h"
#include "scene/view_reader.h"
#include "scene/workspace_reader.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxSceneFileBytes = std::size_t{1} << 24;

struct SceneSpec {
  std::vector<ObjectSpec> objects;
  MaterialSpecs materials;
  std::vector<EffectSpec> effects;
  std::vector<LibraryEffect> libraries;  // effects from plug-ins
  std::optional<ObjectSpec> tool;
  std::optional<Vec3> fit_m;
  std::optional<SceneFit> workspace;  // in place of fit_m
  SceneView view;
  bool is_plain = false;  // the scene is a single mesh file
};

Result<void> read_materials(const toml::table& table, SceneSpec& spec) {
  const toml::node* node = table.get("material");
  if (node == nullptr) return {};
  if (!node->is_table()) return fail("line {}: 'material' must be tables such as [material.steel]", node->source().begin.line);
  for (const auto& [key, value] : *node->as_table()) {
    if (!value.is_table()) return fail("line {}: 'material' must be tables such as [material.steel]", value.source().begin.line);
    Result<MaterialSpec> material = read_material(*value.as_table(), std::string(key.str()));
    if (!material) return tl::unexpected(material.error());
    material->line = value.source().begin.line;
    spec.materials.emplace(key.str(), std::move(*material));
  }
  return {};
}

void note_unused_materials(const SceneSpec& spec, std::vector<std::string>& notes) {
  for (const auto& [name, material] : spec.materials) {
    const auto uses_it = [&, &name = name](const ObjectSpec& object) { return object.material == name; };
    if (std::any_of(spec.objects.begin(), spec.objects.end(), uses_it)) continue;
    notes.push_back(fmt::format("line {}: no object uses [material.{}]", material.line, printable(name)));
  }
}

Result<void> read_effects(const toml::table& table, SceneSpec& spec) {
  const toml::node* node = table.get("effect");
  if (node == nullptr) return {};
  const toml::array* effects = node->as_array();
  if (effects == nullptr || !effects->is_array_of_tables()) {
    return fail("line {}: 'effect' must be tables that begin with [[effect]]", node->source().begin.line);
  }
  for (const toml::node& one : *effects) {
    const std::size_t number = spec.effects.size() + spec.libraries.size() + 1;
    if (is_library_effect(*one.as_table())) {
      Result<LibraryEffect> library = read_library_effect(*one.as_table(), number);
      if (!library) return tl::unexpected(library.error());
      spec.libraries.push_back(std::move(*library));
      continue;
    }
    Result<EffectSpec> effect = read_space_effect(*one.as_table(), number);
    if (!effect) return tl::unexpected(effect.error());
    spec.effects.push_back(std::move(*effect));
  }
  return {};
}

Result<void> read_tool(const toml::table& table, SceneSpec& spec) {
  const toml::node* node = table.get("tool");
  if (node == nullptr) return {};
  if (!node->is_table()) return fail("line {}: 'tool' must be one table [tool]", node->source().begin.line);
  Result<ObjectSpec> tool = read_object(*node->as_table(), std::string(kToolTable));
  if (!tool) return tl::unexpected(tool.error());
  spec.tool = std::move(*tool);
  return {};
}

// Turns the objects by the inverse of the rotation of [workspace]; its position and its scale, which are left, are then a SceneFit.
Result<void> set_workspace(const toml::table& table, SceneSpec& spec) {
  const auto workspace = read_workspace(table);
  if (!workspace) return tl::unexpected(workspace.error());
  if (!*workspace) return {};
  const Quat back = (*workspace)->q.conjugate();
  spec.workspace = SceneFit{back * (*workspace)->p, 1.0 / (*workspace)->scale};
  for (ObjectSpec& object : spec.objects) {
    move_by({.scale = 1.0, .q = back, .p = Vec3::Zero()}, object);
    object.q_SF = back;
  }
  return {};
}

Result<SceneSpec> read_spec(const toml::table& table) {
  SceneSpec spec;
  TableReader reader(table, "the scene");
  reader.allow({"fit_m", "object", "group", "instance", "material", "effect", "tool", "workspace", "camera", "light", "probe"});
  std::array<double, 3> fit = {};
  reader.read("fit_m", fit, 1e-9, kMaxLengthM);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (const auto checked = find_misplaced_key(table); !checked) return tl::unexpected(checked.error());
  if (reader.has("fit_m")) spec.fit_m = Vec3(fit[0], fit[1], fit[2]);
  if (const auto read = read_materials(table, spec); !read) return tl::unexpected(read.error());
  std::vector<std::string_view> materials;
  for (const auto& [name, material] : spec.materials) materials.emplace_back(name);
  auto objects = read_scene_objects(table, materials);
  if (!objects) return tl::unexpected(objects.error());
  spec.objects = std::move(*objects);
  if (const auto read = read_effects(table, spec); !read) return tl::unexpected(read.error());
  if (const auto read = read_tool(table, spec); !read) return tl::unexpected(read.error());
  if (const auto set = set_workspace(table, spec); !set) return tl::unexpected(set.error());
  if (const auto probes = read_probes(table); !probes) return tl::unexpected(probes.error());  // only checked; haptics_node uses them
  auto view = read_view(table);
  if (!view) return tl::unexpected(view.error());
  spec.view = std::move(*view);
  return spec;
}

// Fits all meshes together into the box of spec.fit_m, or, if there is a [workspace], moves and scales them by that: even if
// parts of them are then outside of the device's workspace.
Result<SceneFit> fit(std::vector<PosedMesh>& meshes, const SceneSpec& spec, std::vector<std::string>& notes) {
  if (spec.workspace) {
    apply_fit(*spec.workspace, meshes);
    note_scale("[workspace]", *spec.workspace, notes);
    return *spec.workspace;
  }
  Eigen::AlignedBox3d box;
  for (const PosedMesh& posed : meshes) box.extend(posed.box);
  const Result<SceneFit> fit = find_fit(box, *spec.fit_m);
  if (!fit) return fail("fit_m: {}: leave fit_m out", fit.error().what);
  apply_fit(*fit, meshes);
  if (spec.is_plain) {
    notes.push_back(describe_fit(spec.objects[0].mesh, box, *fit));
  } else {
    note_scale("fit_m", *fit, notes);
  }
  return *fit;
}

// Adds the tool: its mesh, in its pose, is moved so that the grip point is the origin, and scaled as the scene is.
Result<void> add_tool(const ObjectSpec& spec, const std::filesystem::path& folder, MeshCache& cache, Scene& scene) {
  Result<PosedMesh> posed = make_posed_mesh(spec, folder, cache, scene.notes);
  if (!posed) return tl::unexpected(posed.error());
  SceneTool tool;
  tool.name = !spec.name.empty() ? spec.name : !spec.part.empty() ? spec.part : std::filesystem::path(spec.mesh).stem().string();
  tool.mesh = std::make_shared<const TriangleMesh>(from_grip(std::move(posed->mesh), spec.grip, scene.fit_scale));
  if (spec.has_colour) tool.colour = spec.colour;
  tool.given_hash = hash_tool(posed->given_hash, spec.grip);
  scene.given_hash = combine_hashes(scene.given_hash, posed->given_hash);
  scene.tool = std::move(tool);
  return {};
}

// Adds the effects. If an effect names an object, it is placed at the bounding box of the mesh with which that object is touched.
Result<void> add_effects(const SceneSpec& spec, Scene& scene) {
  for (const EffectSpec& effect : spec.effects) {
    scene.effects.push_back({.name = effect.name, .effect = effect.effect, .on = effect.on});
    if (effect.object.empty()) continue;
    std::vector<std::string_view> names;
    Eigen::AlignedBox3d box;
    for (const SceneObject& object : scene.objects) {
      names.emplace_back(object.name);
      if (object.name != effect.object) continue;
      if (!box.isEmpty())
        return fail("line {}: several objects have the name {}: give each its own", effect.object_line, printable(effect.object));
      for (const Vec3& vertex : object.mesh->vertices) box.extend(vertex);
    }
    if (box.isEmpty()) {
      return fail("line {}: there is no object named {}{}", effect.object_line, printable(effect.object),
                  similar_word_hint(effect.object, names));
    }
    place_at_object(scene.effects.back().effect, box.min(), box.max());
  }
  return {};
}

// An object that plays an animation becomes one object for each motion in it.
Result<std::vector<ObjectSpec>> split_objects(const SceneSpec& spec, const std::filesystem::path& folder, MeshCache& cache,
                                              std::vector<std::string>& notes) {
  std::vector<ObjectSpec> objects;
  for (const ObjectSpec& object : spec.objects) {
    if (object.motion.animation.empty()) {
      objects.push_back(object);
      continue;
    }
    const std::filesystem::path path = (folder / object.mesh).lexically_normal();
    const auto file = cache.load_file(path, object, notes);
    if (!file) return tl::unexpected(file.error());
    auto split = split_animated(object, name_of(object), **file);
    if (!split) return fail("line {}: {}: {}", object.motion.animation_line, path.string(), split.error().what);
    objects.insert(objects.end(), std::make_move_iterator(split->begin()), std::make_move_iterator(split->end()));
  }
  return objects;
}

// An object as it is felt: with its material.
struct FeltObject {
  ObjectSpec object;
  MaterialSpec material;
};

// The objects with their materials. One without a material in the scene file becomes one object for each material of its mesh file.
Result<std::vector<FeltObject>> find_materials(const SceneSpec& spec, const std::filesystem::path& folder, MeshCache& cache,
                                               std::vector<std::string>& notes) {
  std::vector<FeltObject> felt;
  const auto objects = split_objects(spec, folder, cache, notes);
  if (!objects) return tl::unexpected(objects.error());
  for (const ObjectSpec& object : *objects) {
    if (!object.material.empty()) {
      felt.push_back({object, spec.materials.find(object.material)->second});
      continue;
    }
    const std::filesystem::path path = (folder / object.mesh).lexically_normal();
    const auto choice = cache.find_haptics(path, object, notes);
    if (!choice) return tl::unexpected(choice.error());
    if ((object.is_movable || object.moves_by_program()) && choice->materials.size() > 1) {
      return fail(
          "line {}: object '{}' is {}, but its triangles have {} haptic materials ('none' counts as one): name a part with only one, or "
          "give it a material",
          object.mesh_line, printable(name_of(object)), object.is_movable ? "movable" : "moved by programs", choice->materials.size());
    }
    if (choice->haptics == nullptr) felt.push_back({object, {}});
    for (const std::uint32_t index : choice->materials) {
      FeltObject part = {object, {}};
      part.object.haptic_material = index;
      if (index != TriangleAppearance::kNoMaterial) {
        const HapticMaterial& haptic = choice->haptics->materials[index];
        const auto material = cache.find_material(path, *choice->haptics, index);
        if (!material) return tl::unexpected(material.error());
        part.material = **material;
        const std::string own = haptic.name.empty() ? fmt::format("haptic material {}", index) : haptic.name;
        if (choice->materials.size() > 1) part.object.name = fmt::format("{}/{}", name_of(object), own);
      }
      felt.push_back(std::move(part));
    }
  }
  return felt;
}

Result<std::optional<SculptSettings>> make_felt_sculpt(const ObjectSpec& object, const MaterialSpec& material, const TriangleMesh& mesh) {
  if (!object.sculpt.is_on) return std::optional<SculptSettings>();
  if (material.effects.any() || material.maps.any()) {
    return fail("line {}: '{}' can be carved: its material may have stiffness, damping and friction only", object.sculpt.line,
                printable(name_of(object)));
  }
  const auto made = make_sculpt(object.sculpt, name_of(object), mesh);
  if (!made) return fail("line {}: {}", object.sculpt.line, made.error().what);
  return std::optional(*made);
}

// The number of the line in the scene file that makes the object deform.
std::size_t deforms_line(const ObjectSpec& object) {
  if (object.program_shape.is_on) return object.program_shape.line;
  return object.morphs.empty() ? object.motion.animation_line : object.morphs.front().line;
}

// Snap pulls towards the plane of the last contact after contact has ended. If the surface deforms,
// that plane moves, and nothing says where it is after contact.
Result<std::shared_ptr<const KeyframeMotion>> make_felt_motion(const ObjectSpec& object, const MaterialSpec& material, const SceneFit& fit,
                                                               const TriangleMesh& mesh, std::vector<std::string>& notes) {
  if ((object.deforms() || object.program_shape.is_on) && material.effects.snap.is_on()) {
    return fail("line {}: '{}' deforms: its material may have every effect but snap: leave snap_range_m out", deforms_line(object),
                printable(name_of(object)));
  }
  return make_motion(object, name_of(object), fit, mesh, notes);
}

// Makes an object with all its properties. Takes the mesh out of `posed`, and adds to the scene's hash what matters for touch.
Result<SceneObject> make_object(FeltObject& felt, PosedMesh& posed, const SceneFit& fitted, MapMaker& map_maker, TextureCache& textures,
                                Scene& scene) {
  auto& [object, material] = felt;
  if (material.maps.any()) {
    auto maps = map_maker.make(material.maps, posed.map, name_of(object), scene.notes);
    if (!maps) return tl::unexpected(maps.error());
    material.effects.maps = std::move(*maps);
  }
  auto texture = textures.find(material.texture);
  if (!texture) return tl::unexpected(texture.error());
  material.effects.texture.models = std::move(*texture);
  auto motion = make_felt_motion(object, material, fitted, posed.mesh, scene.notes);
  if (!motion) return tl::unexpected(motion.error());
  if (*motion != nullptr) scene.given_hash = combine_hashes(scene.given_hash, hash_motion(**motion));
  auto deformation = make_deformation(object, name_of(object), fitted, posed.in_file, posed.mesh, motion->get());
  if (!deformation) return tl::unexpected(deformation.error());
  if (*deformation != nullptr) {
    // The hash is that of the mesh in its file, because vision_node does not seal cracks.
    const bool is_sealed = !posed.unsealed_vertices.empty();
    const std::uint64_t hash = hash_deformation(is_sealed ? deform_others(object, fitted, posed.unsealed_vertices) : **deformation);
    scene.given_hash = combine_hashes(scene.given_hash, hash);
  }
  std::shared_ptr<const CommandedObject> commanded;
  if (object.motion.by_program) {
    commanded = std::make_shared<const CommandedObject>(object, fitted, posed.mesh);
    scene.given_hash =
        combine_hashes(scene.given_hash, hash_numbers(std::array{commanded->pivot().x(), commanded->pivot().y(), commanded->pivot().z()}));
  }
  auto shaped = make_program_shape(object, name_of(object), fitted, posed.mesh, posed.sealed);
  if (!shaped) return tl::unexpected(shaped.error());
  if (*shaped != nullptr) scene.given_hash = combine_hashes(scene.given_hash, hash_numbers(std::array{(*shaped)->reach_m}));
  const auto sculpt = make_felt_sculpt(object, material, posed.mesh);
  if (!sculpt) return tl::unexpected(sculpt.error());
  if (*sculpt) scene.given_hash = combine_hashes(scene.given_hash, hash_sculpt(**sculpt));
  return SceneObject{.name = name_of(object),
                     .mesh = std::make_shared<const TriangleMesh>(std::move(posed.mesh)),
                     .material = material.material,
                     .colour = object.colour,
                     .sealed = posed.sealed,
                     .appearance = std::move(posed.appearance),
                     .effects = material.effects,
                     .material_name = object.material,
                     .is_movable = object.is_movable,
                     .motion = std::move(*motion),
                     .deformation = std::move(*deformation),
                     .commanded = std::move(commanded),
                     .program_shape = std::move(*shaped),
                     .sculpt = *sculpt,
                     .mass_kg = object.motion.mass_kg,
                     .line = object.mesh_line};
}

Result<Scene> make_scene(const SceneSpec& spec, const std::filesystem::path& folder, const SceneLoading& loading) {
  Scene scene;
  scene.view = spec.view;
  MeshCache cache(loading.sealing, loading.appearance, reading_for_maps(spec.materials));
  MapMaker map_maker(folder);
  note_unused_materials(spec, scene.notes);
  TextureCache textures(folder);
  Result<std::vector<FeltObject>> felt = find_materials(spec, folder, cache, scene.notes);
  if (!felt) return tl::unexpected(felt.error());
  // Checks the number of triangles of all objects together before their meshes are copied.
  for (const FeltObject& one : *felt) {
    if (const auto counted = cache.count(folder, one.object, scene.notes); !counted) return tl::unexpected(counted.error());
  }
  std::vector<PosedMesh> meshes;
  for (const FeltObject& one : *felt) {
    Result<PosedMesh> mesh = make_posed_mesh(one.object, folder, cache, scene.notes);
    if (!mesh) return tl::unexpected(mesh.error());
    meshes.push_back(std::move(*mesh));
  }
  SceneFit fitted;
  if (spec.fit_m || spec.workspace) {
    const auto found = fit(meshes, spec, scene.notes);
    if (!found) return tl::unexpected(found.error());
    fitted = *found;
    scene.fit_scale = fitted.scale;
  }
  const Vec3 fit_m = spec.fit_m.value_or(Vec3::Zero());
  scene.given_hash = hash_numbers(std::array{fit_m.x(), fit_m.y(), fit_m.z()});
  if (spec.workspace) {
    const Vec3& c = spec.workspace->centre;
    scene.given_hash = combine_hashes(scene.given_hash, hash_numbers(std::array{c.x(), c.y(), c.z(), spec.workspace->scale}));
  }
  for (const PosedMesh& posed : meshes) scene.given_hash = combine_hashes(scene.given_hash, posed.given_hash);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    auto object = make_object((*felt)[i], meshes[i], fitted, map_maker, textures, scene);
    if (!object) return tl::unexpected(object.error());
    scene.objects.push_back(std::move(*object));
  }
  if (const auto added = add_effects(spec, scene); !added) return tl::unexpected(added.error());
  for (const LibraryEffect& named : spec.libraries) {
    scene.libraries.push_back(named.located_in(folder));
    scene.notes.push_back(scene.libraries.back().describe());
  }
  if (spec.tool) {
    if (const auto added = add_tool(*spec.tool, folder, cache, scene); !added) return tl::unexpected(added.error());
  }
  return scene;
}

// Loads a mesh file that has haptic materials.
Result<Scene> load_felt_mesh_as_scene(const std::filesystem::path& path, const SceneLoading& loading) {
  SceneSpec spec;
  spec.is_plain = true;
  spec.objects.emplace_back();
  spec.objects[0].mesh = path.string();
  spec.objects[0].unit = loading.unit;
  if (loading.fit == MeshFit::workspace) spec.fit_m = fitted_size_m();
  return make_scene(spec, {}, loading);
}

Result<Scene> load_mesh_as_scene(const std::filesystem::path& path, const SceneLoading& loading) {
  Result<TouchMesh> file = load_touch_mesh(path, loading.unit, loading.sealing, loading.appearance);
  if (!file) return tl::unexpected(file.error());
  if (file->has_haptics) return load_felt_mesh_as_scene(path, loading);
  Scene scene;
  for (const std::string& note : file->notes) scene.notes.push_back(fmt::format("{}: {}", path.string(), note));
  scene.given_hash = combine_hashes(file->given_hash, static_cast<std::uint64_t>(loading.fit));
  if (loading.fit == MeshFit::workspace) {
    const Result<SceneFit> fit = find_fit(file->box, fitted_size_m());
    if (!fit) return fail("{}: {}", path.string(), fit.error().what);
    fit->apply(file->mesh, file->sealed);
    scene.fit_scale = fit->scale;
    scene.notes.push_back(describe_fit(path.string(), file->box, *fit));
  }
  std::shared_ptr<const MeshAppearance> appearance;
  if (file->appearance.has_colours_or_images()) appearance = std::make_shared<const MeshAppearance>(std::move(file->appearance));
  scene.objects.push_back({.name = path.stem().string(),
                           .mesh = std::make_shared<const TriangleMesh>(std::move(file->mesh)),
                           .material = {},
                           .sealed = file->sealed,
                           .appearance = std::move(appearance)});
  return scene;
}

Result<SceneSpec> parse_spec(const std::string& text) {
  const auto parsed = parse_toml(text);
  if (!parsed) return tl::unexpected(parsed.error());
  return read_spec(*parsed);
}

}  // namespace

TouchScene Scene::touch_scene() const {
  TouchScene touch;
  for (const SceneObject& object : objects) {
    touch.objects.push_back({.mesh = object.mesh,
                             .material = object.material,
                             .effects = object.effects,
                             .motion = object.motion,
                             .deformation = object.deformation,
                             .command_pivot = object.commanded ? std::optional(object.commanded->pivot()) : std::nullopt,
                             .stream_reach_m = object.program_shape ? std::optional(object.program_shape->reach_m) : std::nullopt,
                             .stream_to_scene = object.program_shape ? object.program_shape->to_scene : Mat3(Mat3::Identity()),
                             .sculpt = object.sculpt});
  }
  for (const SceneEffect& effect : effects) touch.effects.emplace_back(effect.effect, effect.on);
  return touch;
}

Result<Scene> load_scene(const std::filesystem::path& path, const SceneLoading& loading) {
  if (path.extension() != ".toml") {
    if (is_mesh_file_name(path)) return load_mesh_as_scene(path, loading);
    const Result<std::string> bytes = read_file_bytes(path, kMaxMeshFileBytes);
    if (!bytes) return tl::unexpected(bytes.error());
    return fail("{}: is neither a scene (.toml) nor a mesh (.obj, .stl, .ply, .gltf, .glb): check its extension", path.string());
  }
  if (loading.unit) return fail("{}: a scene file names its units itself: leave the unit out", path.string());
  const Result<std::string> text = read_file_bytes(path, kMaxSceneFileBytes);
  if (!text) return tl::unexpected(text.error());
  const Result<SceneSpec> spec = parse_spec(*text);
  if (!spec) return fail("{}: {}", path.string(), spec.error().what);
  Result<Scene> scene = make_scene(*spec, path.parent_path(), loading);
  if (!scene) return fail("{}: {}", path.string(), scene.error().what);
  return scene;
}

}  // namespace hapton
