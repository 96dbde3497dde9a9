#include "scene/map_reader.h"

#include <algorithm>
#include <utility>

#include "scene/grey_image.h"
#include "scene/material_limits.h"

namespace hapton {
namespace {

constexpr double kMapMaxHeightM = 10.0;
constexpr double kMapMaxRepeat = 1e4;
constexpr double kMapLeastStiffness = 1e-6;

constexpr std::array<std::string_view, 6> kMapKeys = {"bump_map",     "stiffness_map",      "stiffness_map_n_per_m",
                                                      "friction_map", "friction_map_range", "map_repeat"};

void read_file_name(const toml::table& table, TableReader& reader, std::string_view key, MapSpec& spec) {
  reader.read(key, spec.file);
  if (!reader.has(key)) return;
  spec.where = fmt::format("line {}", table.get(key)->source().begin.line);
  if (spec.file.empty()) reader.fail_at(key, "'{}' is empty: name an image, PNG or JPEG", key);
}

// Error: a pair of numbers without its image, or an image without its numbers.
void need_both(TableReader& reader, std::string_view image, std::string_view numbers) {
  if (reader.has(image) && !reader.has(numbers)) reader.fail_at(image, "'{}' needs '{}': the number at black and at white", image, numbers);
  if (reader.has(numbers) && !reader.has(image)) reader.fail_at(numbers, "'{}' has no effect without '{}'", numbers, image);
}

void read_height(const toml::table& table, TableReader& reader, const Material& material, MapSpec& spec) {
  read_file_name(table, reader, "bump_map", spec);
  if (!reader.has("bump_map")) return;
  for (const char* key : {"bump_length_m", "bump_pattern", "bump_direction"}) {
    if (reader.has(key)) reader.fail_at(key, "'{}' belongs to bumps by a formula: leave it out, or leave out 'bump_map'", key);
  }
  if (!reader.has("bump_height_m")) reader.fail_at("bump_map", "'bump_map' needs 'bump_height_m': from black to white");
  double height_m = 0.0;
  reader.read("bump_height_m", height_m, 0.0, kMapMaxHeightM, true);
  spec.at_black = -height_m;
  if (material.damping_ns_per_m > 0.0) {
    reader.fail_at("bump_map",
                   "'bump_map' is set beside 'damping_ns_per_m' = {}: bumps would turn its damping into a source of energy; set that to 0, "
                   "or use 'viscosity_ns_per_m'",
                   material.damping_ns_per_m);
  }
}

void read_stiffness(const toml::table& table, TableReader& reader, Material& material, const SurfaceEffects& effects, MapSpec& spec) {
  read_file_name(table, reader, "stiffness_map", spec);
  need_both(reader, "stiffness_map", "stiffness_map_n_per_m");
  if (!reader.has("stiffness_map")) return;
  if (reader.has("stiffness_n_per_m")) reader.fail_at("stiffness_n_per_m", "'stiffness_n_per_m' is set beside 'stiffness_map': keep one");
  if (effects.layers.is_on()) reader.fail_at("stiffness_map", "'stiffness_map' has no effect beside layers, which replace the stiffness");
  if (material.damping_ns_per_m > 0.0) reader.fail_at("stiffness_map", "'stiffness_map' needs 'damping_ns_per_m' = 0");
  std::array<double, 2> range = {};
  reader.read("stiffness_map_n_per_m", range, kMapLeastStiffness, kStiffnessLimit.most);
  if (reader.error()) return;
  material.stiffness_n_per_m = std::max(range[0], range[1]);
  spec.at_black = range[0] / material.stiffness_n_per_m;
  spec.at_white = range[1] / material.stiffness_n_per_m;
}

void read_friction(const toml::table& table, TableReader& reader, const Material& material, MapSpec& spec) {
  read_file_name(table, reader, "friction_map", spec);
  need_both(reader, "friction_map", "friction_map_range");
  if (!reader.has("friction_map")) return;
  if (material.friction_static > 0.0) {
    reader.fail_at("friction_map", "'friction_map' replaces 'friction_static' and 'friction_dynamic': leave these out");
  }
  std::array<double, 2> range = {};
  reader.read("friction_map_range", range, 0.0, kFrictionStaticLimit.most);
  spec.at_black = range[0];
  spec.at_white = range[1];
}

std::vector<MappedTriangle> place_triangles(const MapSource& source, const std::array<double, 2>& repeat) {
  std::vector<MappedTriangle> triangles;
  if (source.look == nullptr || !source.look->has_texcoords() || source.look->triangles.size() != source.mesh->triangles.size())
    return triangles;
  const Eigen::Vector2d times(repeat[0], repeat[1]);
  for (std::size_t t = 0; t < source.mesh->triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = source.vertices[source.mesh->triangles[t][k]];
      made.texcoord[k] = source.look->triangles[t].corners[k].texcoord.cast<double>().cwiseProduct(times);
    }
    triangles.push_back(made);
  }
  return triangles;
}

}  // namespace

std::span<const std::string_view> map_keys() { return kMapKeys; }

void read_maps(const toml::table& table, TableReader& reader, Material& material, const SurfaceEffects& effects, MapSpecs& specs) {
  read_height(table, reader, material, specs.height);
  read_stiffness(table, reader, material, effects, specs.stiffness);
  read_friction(table, reader, material, specs.friction);
  reader.read("map_repeat", specs.repeat, 1.0 / kMapMaxRepeat, kMapMaxRepeat);
  if (reader.has("map_repeat") && !specs.any()) reader.fail_at("map_repeat", "'map_repeat' has no effect without a map");
}

std::filesystem::path MapMaker::shown_path(const MapSpec& spec) const {
  return spec.bytes != nullptr ? std::filesystem::path(spec.file) : (folder_ / spec.file).lexically_normal();
}

Result<ImageMap> MapMaker::make_map(const MapSpec& spec, std::string_view key) {
  ImageMap map{.image = {}, .at_black = spec.at_black, .at_white = spec.at_white};
  if (spec.file.empty()) return map;
  auto found = images_.find(spec.file);
  if (found == images_.end()) {
    const auto image = spec.bytes != nullptr ? decode_grey_image(*spec.bytes).map_error([&](const Error& error) {
      return Error{fmt::format("{} {}", spec.file, error.what)};
    })
                                             : read_grey_image(shown_path(spec));
    if (!image) return fail("{}: '{}': {}", spec.where, key, image.error().what);
    found = images_.emplace(spec.file, std::make_shared<const SurfaceImage>(std::move(*image))).first;
  }
  map.image = found->second;
  return map;
}

Result<SurfaceMaps> MapMaker::make(const MapSpecs& specs, const MapSource& source, const std::string& object,
                                   std::vector<std::string>& notes) {
  SurfaceMaps maps;
  auto triangles = place_triangles(source, specs.repeat);
  if (triangles.empty()) {
    const bool is_height = !specs.height.file.empty();
    const MapSpec& first = is_height ? specs.height : specs.stiffness.file.empty() ? specs.friction : specs.stiffness;
    const char* key = is_height ? "bump_map" : specs.stiffness.file.empty() ? "friction_map" : "stiffness_map";
    return fail("{}: '{}' needs texture coordinates, and the mesh of object '{}' has none: unwrap it", first.where, key, printable(object));
  }
  maps.triangles = std::make_shared<const std::vector<MappedTriangle>>(std::move(triangles));
  const struct {
    const MapSpec& spec;
    std::string_view key;
    ImageMap& map;
  } all[] = {{specs.height, "bump_map", maps.height},
             {specs.stiffness, "stiffness_map", maps.stiffness},
             {specs.friction, "friction_map", maps.friction}};
  for (const auto& one : all) {
    auto map = make_map(one.spec, one.key);
    if (!map) return tl::unexpected(map.error());
    one.map = std::move(*map);
  }
  if (!maps.height.is_on()) return maps;
  const double given = maps.height.steepest(*maps.triangles);
  for (double slope = given; slope > SurfaceMaps::kSteepest; slope = maps.height.steepest(*maps.triangles)) {
    maps.height.image = std::make_shared<const SurfaceImage>(maps.height.image->halved());
  }
  if (given > SurfaceMaps::kSteepest) {
    notes.push_back(
        fmt::format("{}: object '{}': bumps of slope {:.3g}, above {}, are smoothed to {} x {} texels; a lower bump_height_m keeps them",
                    shown_path(specs.height).string(), printable(object), given, SurfaceMaps::kSteepest, maps.height.image->width(),
                    maps.height.image->height()));
  }
  return maps;
}

}  // namespace hapton
