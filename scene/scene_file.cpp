#include "scene/scene_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/base/near_miss.h"
#include "scene/effect_reader.h"
#include "scene/file_bytes.h"
#include "scene/map_reader.h"
#include "scene/material_limits.h"
#include "scene/mesh_file.h"
#include "scene/object_reader.h"
#include "scene/scene_hash.h"
#include "scene/table_reader.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxSceneFileBytes = std::size_t{1} << 24;

struct MaterialSpec {
  Material material;
  SurfaceEffects effects;
  MapSpecs maps;
};

void read_number(TableReader& reader, const MaterialLimit& limit, double& value) {
  reader.read(limit.key, value, 0.0, limit.most, limit.above_zero);
}

Result<MaterialSpec> read_material(const toml::table& table, const std::string& name) {
  MaterialSpec spec;
  Material& material = spec.material;
  TableReader reader(table, fmt::format("[material.{}]", printable(name)));
  std::vector<std::string_view> keys = {kStiffnessLimit.key, kDampingLimit.key, kFrictionStaticLimit.key, kFrictionDynamicLimit.key,
                                        "two_sided"};
  keys.insert(keys.end(), surface_effect_keys().begin(), surface_effect_keys().end());
  keys.insert(keys.end(), map_keys().begin(), map_keys().end());
  reader.allow(keys);
  read_number(reader, kStiffnessLimit, material.stiffness_n_per_m);
  read_number(reader, kDampingLimit, material.damping_ns_per_m);
  read_number(reader, kFrictionStaticLimit, material.friction_static);
  read_number(reader, kFrictionDynamicLimit, material.friction_dynamic);
  reader.read("two_sided", material.two_sided);
  if (!reader.error() && material.friction_dynamic > material.friction_static) {
    reader.fail_at("friction_dynamic", "'friction_dynamic' is {}, more than 'friction_static' {}: make it at most that",
                   material.friction_dynamic, material.friction_static);
  }
  const auto effects = read_surface_effects(table, name, material, reader, spec.effects);
  read_maps(table, reader, material, spec.effects, spec.maps);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (!effects) return tl::unexpected(effects.error());
  return spec;
}

struct SceneSpec {
  std::vector<ObjectSpec> objects;
  std::map<std::string, MaterialSpec, std::less<>> materials;
  std::vector<EffectSpec> effects;
  std::optional<ObjectSpec> tool;
  std::optional<Vec3> fit_m;

  bool has_maps() const {
    return std::any_of(materials.begin(), materials.end(), [](const auto& one) { return one.second.maps.any(); });
  }
};

Result<void> read_materials(const toml::table& table, SceneSpec& spec) {
  const toml::node* node = table.get("material");
  if (node == nullptr) return {};
  if (!node->is_table()) return fail("line {}: 'material' must be tables such as [material.steel]", node->source().begin.line);
  for (const auto& [key, value] : *node->as_table()) {
    if (!value.is_table()) return fail("line {}: 'material' must be tables such as [material.steel]", value.source().begin.line);
    const Result<MaterialSpec> material = read_material(*value.as_table(), std::string(key.str()));
    if (!material) return tl::unexpected(material.error());
    spec.materials.emplace(key.str(), *material);
  }
  return {};
}

Result<void> check_material(const ObjectSpec& object, const SceneSpec& spec) {
  if (object.material.empty() || spec.materials.contains(object.material)) return {};
  std::vector<std::string_view> known;
  for (const auto& [name, material] : spec.materials) known.emplace_back(name);
  return fail("line {}: there is no [material.{}]{}", object.material_line, printable(object.material),
              known.empty() ? ": add it" : near_miss_hint(object.material, known));
}

Result<void> read_effects(const toml::table& table, SceneSpec& spec) {
  const toml::node* node = table.get("effect");
  if (node == nullptr) return {};
  const toml::array* effects = node->as_array();
  if (effects == nullptr || !effects->is_array_of_tables()) {
    return fail("line {}: 'effect' must be tables that begin with [[effect]]", node->source().begin.line);
  }
  for (const toml::node& one : *effects) {
    Result<EffectSpec> effect = read_space_effect(*one.as_table(), spec.effects.size() + 1);
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

Result<SceneSpec> read_spec(const toml::table& table) {
  SceneSpec spec;
  TableReader reader(table, "the scene");
  reader.allow({"fit_m", "object", "material", "effect", "tool"});
  std::array<double, 3> fit = {};
  reader.read("fit_m", fit, 1e-9, kMaxLengthM);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (reader.has("fit_m")) spec.fit_m = Vec3(fit[0], fit[1], fit[2]);
  if (const auto read = read_materials(table, spec); !read) return tl::unexpected(read.error());
  const toml::array* objects = table["object"].as_array();
  const toml::node* given = table.get("object");
  const bool is_empty = objects != nullptr && objects->empty();
  if (given != nullptr && !is_empty && (objects == nullptr || !objects->is_array_of_tables())) {
    return fail("line {}: 'object' must be tables that begin with [[object]]", given->source().begin.line);
  }
  if (objects == nullptr || is_empty) return fail("there is no [[object]]: add one with its mesh");
  for (const toml::node& node : *objects) {
    Result<ObjectSpec> object = read_object(*node.as_table(), fmt::format("[[object]] {}", spec.objects.size() + 1));
    if (!object) return tl::unexpected(object.error());
    if (const auto known = check_material(*object, spec); !known) return tl::unexpected(known.error());
    spec.objects.push_back(std::move(*object));
  }
  if (const auto read = read_effects(table, spec); !read) return tl::unexpected(read.error());
  if (const auto read = read_tool(table, spec); !read) return tl::unexpected(read.error());
  return spec;
}

// Each file is read once, and each of its parts made ready for touch once, however many objects are made of it.
class MeshCache {
 public:
  struct ReadyMesh {
    TriangleMesh mesh;
    SealReport sealed;
    std::vector<Vec3> vertices_before;  // if it was sealed: the vertices before that
    std::uint64_t given_hash = 0;
    std::shared_ptr<const MeshLook> look;  // null: none
    MapSource map;                         // if there are maps: the mesh before it was sealed
  };

  // has_maps: texture coordinates are needed, whether colours are or not.
  MeshCache(CrackSealing sealing, LookReading look, bool has_maps) : sealing_(sealing), look_(look), has_maps_(has_maps) {}

  // A part of a file, or all of it where no part is named.
  Result<const ReadyMesh*> load(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes) {
    const CrackSealing sealing = object.seal_cracks ? sealing_ : CrackSealing::off;
    const auto key = std::make_tuple(path.string(), object.unit, object.part, sealing);
    auto found = meshes_.find(key);
    if (found == meshes_.end()) {
      const Result<const MeshFile*> file = load(path, object.unit, notes);
      if (!file) return fail("line {}: {}", object.mesh_line, file.error().what);
      MeshLook look;
      if (object.part.empty()) look = (*file)->look;
      Result<TriangleMesh> mesh = object.part.empty() ? Result<TriangleMesh>((*file)->mesh) : extract_part(**file, object.part, &look);
      if (!mesh) return fail("line {}: {}: {}", object.part_line, path.string(), mesh.error().what);
      ReadyMesh ready;
      std::vector<Vec3> vertices = mesh->vertices;
      ready.given_hash = hash_mesh(*mesh);
      if (has_maps_) ready.map = {{}, std::make_shared<const TriangleMesh>(*mesh), std::make_shared<const MeshLook>(look)};
      ready.sealed = seal_for_touch(*mesh, sealing);
      ready.mesh = std::move(*mesh);
      if (ready.sealed.has_sealed()) ready.vertices_before = std::move(vertices);
      if (look_ == LookReading::on && !ready.sealed.has_sealed() && look.says_anything())
        ready.look = std::make_shared<const MeshLook>(std::move(look));
      if (ready.sealed.is_worth_a_note()) {
        notes.push_back(
            fmt::format("{}{}: {}", path.string(), object.part.empty() ? "" : " " + printable(object.part), ready.sealed.describe()));
      }
      found = meshes_.emplace(key, std::move(ready)).first;
    }
    return &found->second;
  }

 private:
  Result<const MeshFile*> load(const std::filesystem::path& path, std::optional<Unit> unit, std::vector<std::string>& notes) {
    const auto key = std::make_pair(path.string(), unit);
    auto found = files_.find(key);
    if (found == files_.end()) {
      Result<MeshFile> file = load_mesh_file(path, unit, has_maps_ ? LookReading::on : look_);
      if (!file) return tl::unexpected(file.error());
      for (const std::string& note : file->notes) notes.push_back(fmt::format("{}: {}", path.string(), note));
      found = files_.emplace(key, std::move(*file)).first;
    }
    return &found->second;
  }

  CrackSealing sealing_;
  LookReading look_;
  bool has_maps_;
  std::map<std::pair<std::string, std::optional<Unit>>, MeshFile> files_;
  std::map<std::tuple<std::string, std::optional<Unit>, std::string, CrackSealing>, ReadyMesh> meshes_;
};

// A mesh in its pose.
struct PosedMesh {
  TriangleMesh mesh;
  SealReport sealed;
  Eigen::AlignedBox3d box;       // of the mesh before sealing
  std::uint64_t given_hash = 0;  // of that mesh and its pose
  std::shared_ptr<const MeshLook> look;
  MapSource map = {};  // if there are maps
};

void scale_widths(SealReport& sealed, double scale) {
  sealed.widest_gap *= scale;
  sealed.tolerance *= scale;
}

Result<PosedMesh> make_mesh(const ObjectSpec& object, const std::filesystem::path& folder, MeshCache& cache,
                            std::vector<std::string>& notes) {
  const std::filesystem::path path = (folder / object.mesh).lexically_normal();
  const Result<const MeshCache::ReadyMesh*> loaded = cache.load(path, object, notes);
  if (!loaded) return tl::unexpected(loaded.error());
  const auto pose = [&](const Vec3& vertex) { return Vec3(object.p_SM + object.q_SM * (object.scale * vertex)); };
  PosedMesh posed{.mesh = (*loaded)->mesh, .sealed = (*loaded)->sealed, .box = {}, .given_hash = 0, .look = (*loaded)->look};
  if (object.has_colour) posed.look.reset();
  const Vec3& p_SM = object.p_SM;
  const std::array numbers = {object.scale,    object.q_SM.w(), object.q_SM.x(), object.q_SM.y(),
                              object.q_SM.z(), p_SM.x(),        p_SM.y(),        p_SM.z()};
  posed.given_hash = combine_hashes((*loaded)->given_hash, hash_numbers(numbers));
  for (const Vec3& vertex : posed.sealed.has_sealed() ? (*loaded)->vertices_before : posed.mesh.vertices) posed.box.extend(pose(vertex));
  for (Vec3& vertex : posed.mesh.vertices) vertex = pose(vertex);
  posed.map = (*loaded)->map;
  if (posed.map.mesh != nullptr) {
    for (const Vec3& vertex : posed.map.mesh->vertices) posed.map.vertices.push_back(pose(vertex));
  }
  const Eigen::Quaternionf turn = object.q_SM.cast<float>();
  for (auto& normals : posed.mesh.authored_normals) normals = {turn * normals[0], turn * normals[1], turn * normals[2]};
  scale_widths(posed.sealed, object.scale);
  return posed;
}

// Scales and shifts a mesh. RT: no.
struct Fit {
  Vec3 centre;
  double scale;
  void apply(TriangleMesh& mesh, SealReport& sealed) const {
    for (Vec3& vertex : mesh.vertices) vertex = scale * (vertex - centre);
    scale_widths(sealed, scale);
  }
};

// The largest scale, and the shift, that fit the box into one of size_m around the origin.
Result<Fit> find_fit(const Eigen::AlignedBox3d& box, const Vec3& size_m) {
  if (!(box.sizes().maxCoeff() > 0.0)) return fail("all vertices are one point, which no scale makes larger");
  return Fit{box.center(), (size_m.array() / box.sizes().array()).minCoeff()};
}

// Fits all meshes together into a box of size_m.
Result<double> fit(std::vector<PosedMesh>& meshes, const Vec3& size_m, std::vector<std::string>& notes) {
  Eigen::AlignedBox3d box;
  for (const PosedMesh& posed : meshes) box.extend(posed.box);
  const Result<Fit> fit = find_fit(box, size_m);
  if (!fit) return fail("fit_m: {}: leave fit_m out", fit.error().what);
  for (PosedMesh& posed : meshes) {
    fit->apply(posed.mesh, posed.sealed);
    for (Vec3& vertex : posed.map.vertices) vertex = fit->scale * (vertex - fit->centre);
  }
  const double scale = fit->scale;
  notes.push_back(fmt::format("fit_m: everything is shown {:.4g} times its size", scale));
  return scale;
}

// In its pose from the mesh's origin, then held where its grip is, as large as the scene.
Result<void> add_tool(const ObjectSpec& spec, const std::filesystem::path& folder, MeshCache& cache, Scene& scene) {
  Result<PosedMesh> posed = make_mesh(spec, folder, cache, scene.notes);
  if (!posed) return tl::unexpected(posed.error());
  SceneTool tool;
  tool.name = !spec.name.empty() ? spec.name : !spec.part.empty() ? spec.part : std::filesystem::path(spec.mesh).stem().string();
  tool.mesh = std::make_shared<const TriangleMesh>(from_grip(std::move(posed->mesh), spec.grip, scene.fit_scale));
  if (spec.has_colour) tool.colour = spec.colour;
  scene.given_hash = combine_hashes(scene.given_hash, posed->given_hash);
  scene.tool = std::move(tool);
  return {};
}

// Effects that an object places go to it; its box is that of the mesh as it is touched.
Result<void> add_effects(const SceneSpec& spec, Scene& scene) {
  for (const EffectSpec& effect : spec.effects) {
    scene.effects.push_back({.name = effect.name, .effect = effect.effect});
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
                  near_miss_hint(effect.object, names));
    }
    place_at_object(scene.effects.back().effect, box.min(), box.max());
  }
  return {};
}

Result<Scene> make_scene(const SceneSpec& spec, const std::filesystem::path& folder, const SceneLoading& loading) {
  Scene scene;
  MeshCache cache(loading.sealing, loading.look, spec.has_maps());
  MapMaker map_maker(folder);
  std::vector<PosedMesh> meshes;
  for (const ObjectSpec& object : spec.objects) {
    Result<PosedMesh> mesh = make_mesh(object, folder, cache, scene.notes);
    if (!mesh) return tl::unexpected(mesh.error());
    meshes.push_back(std::move(*mesh));
  }
  if (spec.fit_m) {
    const auto fitted = fit(meshes, *spec.fit_m, scene.notes);
    if (!fitted) return tl::unexpected(fitted.error());
    scene.fit_scale = *fitted;
  }
  const Vec3 fit_m = spec.fit_m.value_or(Vec3::Zero());
  scene.given_hash = hash_numbers(std::array{fit_m.x(), fit_m.y(), fit_m.z()});
  for (const PosedMesh& posed : meshes) scene.given_hash = combine_hashes(scene.given_hash, posed.given_hash);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const ObjectSpec& object = spec.objects[i];
    const std::string own_name = object.part.empty() ? std::filesystem::path(object.mesh).stem().string() : object.part;
    MaterialSpec material = object.material.empty() ? MaterialSpec() : spec.materials.find(object.material)->second;
    if (material.maps.any()) {
      auto maps = map_maker.make(material.maps, meshes[i].map, object.name.empty() ? own_name : object.name, scene.notes);
      if (!maps) return tl::unexpected(maps.error());
      material.effects.maps = std::move(*maps);
    }
    scene.objects.push_back({.name = object.name.empty() ? own_name : object.name,
                             .mesh = std::make_shared<const TriangleMesh>(std::move(meshes[i].mesh)),
                             .material = material.material,
                             .colour = object.colour,
                             .sealed = meshes[i].sealed,
                             .look = std::move(meshes[i].look),
                             .effects = material.effects,
                             .material_name = object.material,
                             .is_movable = object.is_movable});
  }
  if (const auto added = add_effects(spec, scene); !added) return tl::unexpected(added.error());
  if (spec.tool) {
    if (const auto added = add_tool(*spec.tool, folder, cache, scene); !added) return tl::unexpected(added.error());
  }
  return scene;
}

Result<Scene> load_mesh_as_scene(const std::filesystem::path& path, const SceneLoading& loading) {
  Result<TouchMesh> file = load_touch_mesh(path, loading.unit, loading.sealing, loading.look);
  if (!file) return tl::unexpected(file.error());
  Scene scene;
  for (const std::string& note : file->notes) scene.notes.push_back(fmt::format("{}: {}", path.string(), note));
  scene.given_hash = combine_hashes(file->given_hash, static_cast<std::uint64_t>(loading.fit));
  if (loading.fit == MeshFit::workspace) {
    Eigen::AlignedBox3d box;
    for (const Vec3& vertex : file->mesh.vertices) box.extend(vertex);
    const Result<Fit> fit = find_fit(box, fitted_size_m());
    if (!fit) return fail("{}: {}", path.string(), fit.error().what);
    fit->apply(file->mesh, file->sealed);
    scene.fit_scale = fit->scale;
    scene.notes.push_back(
        fmt::format("{}: is {:.4g} m long, shown {:.4g} times its size in the middle of the workspace; --no-fit leaves it as it is",
                    path.string(), box.sizes().maxCoeff(), fit->scale));
  }
  std::shared_ptr<const MeshLook> look;
  if (file->look.says_anything()) look = std::make_shared<const MeshLook>(std::move(file->look));
  scene.objects.push_back({.name = path.stem().string(),
                           .mesh = std::make_shared<const TriangleMesh>(std::move(file->mesh)),
                           .material = {},
                           .sealed = file->sealed,
                           .look = std::move(look)});
  return scene;
}

Result<SceneSpec> parse_spec(const std::string& text) {
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    std::string what(parsed.error().description());
    std::replace(what.begin(), what.end(), '\n', ' ');
    return fail("line {}: {}", parsed.error().source().begin.line, what);
  }
  return read_spec(parsed.table());
}

}  // namespace

TouchScene Scene::touch_scene() const {
  TouchScene touch;
  for (const SceneObject& object : objects) {
    touch.objects.push_back({.mesh = object.mesh, .material = object.material, .effects = object.effects});
  }
  for (const SceneEffect& effect : effects) touch.effects.push_back(effect.effect);
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
