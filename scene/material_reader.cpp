#include "scene/material_reader.h"

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "scene/effect_reader.h"
#include "scene/material_limits.h"

namespace hapton {
namespace {

using Json = nlohmann::json;

// Largest depth of a value: a list of tables of numbers.
constexpr int kDeepestNumbers = 3;

void read_number(TableReader& reader, const MaterialLimit& limit, double& value) {
  reader.read(limit.key, value, 0.0, limit.most, limit.above_zero);
}

// where: what error messages call the table.
Result<MaterialSpec> read_table(const toml::table& table, const std::string& where, const std::string& name) {
  MaterialSpec spec;
  Material& material = spec.material;
  TableReader reader(table, where);
  std::vector<std::string_view> keys = {kStiffnessLimit.key, kDampingLimit.key, kFrictionStaticLimit.key, kFrictionDynamicLimit.key,
                                        "two_sided"};
  keys.insert(keys.end(), surface_effect_keys().begin(), surface_effect_keys().end());
  keys.insert(keys.end(), map_keys().begin(), map_keys().end());
  keys.insert(keys.end(), texture_keys().begin(), texture_keys().end());
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
  read_texture(table, reader, spec.effects.texture, spec.texture);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (!effects) return tl::unexpected(effects.error());
  return spec;
}

// Where a value goes: into a table by a key, or at the end of an array.
struct TomlPlace {
  toml::table* table = nullptr;
  std::string key = {};
  toml::array* array = nullptr;

  template <class Value>
  void add(Value&& value) const {
    if (table != nullptr) {
      table->insert(key, std::forward<Value>(value));
    } else {
      array->push_back(std::forward<Value>(value));
    }
  }
};

// Adds a JSON value. If scene files have no such type, an empty table is added, which every reader rejects.
void add_value(const Json& json, int depth, const TomlPlace& to) {
  if (json.is_boolean()) return to.add(json.get<bool>());
  if (json.is_number()) return to.add(json.get<double>());
  if (json.is_string()) return to.add(json.get<std::string>());
  if (json.is_array() && depth > 0) {
    toml::array array;
    for (const Json& value : json) add_value(value, depth - 1, {.array = &array});
    return to.add(std::move(array));
  }
  toml::table table;
  if (json.is_object() && depth > 0) {
    for (const auto& [key, value] : json.items()) add_value(value, depth - 1, {.table = &table, .key = key});
  }
  to.add(std::move(table));
}

// An image for forces: in a scene file, the keys of the image and of its numbers; in a mesh file, the property that has the image.
struct HapticMap {
  const char* image_key;
  const char* numbers_key;
  const char* property;
  std::optional<std::size_t> HapticMaterial::*image;
  MapSpec MapSpecs::*spec;
};

constexpr std::array<HapticMap, 4> kMaps = {
    {{"bump_map", "bump_height_m", "vibrotactileTexture", &HapticMaterial::height, &MapSpecs::height},
     {"stiffness_map", "stiffness_map_n_per_m", "stiffness", &HapticMaterial::stiffness, &MapSpecs::stiffness},
     {"friction_map", "friction_map_range", "friction", &HapticMaterial::friction, &MapSpecs::friction},
     {"viscosity_map", "viscosity_map_ns_per_m", "custom", &HapticMaterial::viscosity, &MapSpecs::viscosity}}};

}  // namespace

AppearanceReading reading_for_maps(const MaterialSpecs& materials) {
  AppearanceReading most = AppearanceReading::off;
  for (const auto& [name, spec] : materials) most = std::max(most, spec.maps.reading());
  return most;
}

Result<MaterialSpec> read_material(const toml::table& table, const std::string& name) {
  return read_table(table, fmt::format("[material.{}]", printable(name)), name);
}

Result<MaterialSpec> read_material(const HapticMaterial& haptic, const MeshAppearance& images, const std::string& mesh) {
  const std::string where = fmt::format("{}: {}", mesh, haptic.where);
  toml::table table;
  const Json numbers = haptic.numbers.empty() ? Json::object() : Json::parse(haptic.numbers, nullptr, false);
  for (const auto& [key, value] : numbers.items()) {
    add_value(value, kDeepestNumbers, {.table = &table, .key = key});
  }
  if (table.contains("map_repeat")) {
    return fail("{}: 'map_repeat' is not for extras.hapton: scale the texture with KHR_texture_transform", where);
  }
  if (table.contains("normal_map")) return fail("{}: 'normal_map' is not for extras.hapton: use a material of a scene file", where);
  for (const std::string_view key : texture_keys()) {
    if (table.contains(key)) return fail("{}: '{}' is not for extras.hapton: use a material of a scene file", where, key);
  }
  for (const HapticMap& map : kMaps) {
    if (table.contains(map.image_key)) {
      return fail("{}: '{}' is not for extras.hapton: the image is the texture of '{}'", where, map.image_key, map.property);
    }
    // The height has a meaning without an image: bumps by a formula have one too.
    if (map.image != &HapticMaterial::height && table.contains(map.numbers_key) && !(haptic.*map.image)) {
      return fail("{}: '{}' has no effect without a texture in '{}': add one, or leave it out", where, map.numbers_key, map.property);
    }
    if (haptic.*map.image) table.insert(map.image_key, images.images[*(haptic.*map.image)].name);
  }
  auto spec = read_table(table, "extras.hapton", haptic.name);
  if (!spec) return fail("{}: {}", where, spec.error().what);
  for (const HapticMap& map : kMaps) {
    if (!(haptic.*map.image)) continue;
    MapSpec& made = spec->maps.*map.spec;
    const TextureImage& image = images.images[*(haptic.*map.image)];
    made.file = fmt::format("{}: {}", mesh, image.name);
    made.where = where;
    made.bytes = std::make_shared<const std::string>(image.bytes);
  }
  return spec;
}

}  // namespace hapton
