#include "scene/map_reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/grey_image.h"
#include "scene/image_texels.h"
#include "scene/material_limits.h"
#include "scene/normal_relief.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr double kMapMaxHeightM = 10.0;
constexpr double kMapMaxRepeat = 1e4;
constexpr double kMapLeastStiffness = 1e-6;
constexpr double kMapMaxViscosity = 1e3;  // Ns/m, as 'viscosity_ns_per_m'

constexpr double kMapMaxNormalScale = 10.0;
constexpr const char* kNormalsOfMesh = "the normal map of the mesh";

constexpr std::array<std::string_view, 10> kMapKeys = {
    "bump_map",     "normal_map",         "normal_map_scale", "stiffness_map",          "stiffness_map_n_per_m",
    "friction_map", "friction_map_range", "viscosity_map",    "viscosity_map_ns_per_m", "map_repeat"};

void read_file_name(const toml::table& table, TableReader& reader, std::string_view key, MapSpec& spec) {
  reader.read(key, spec.file);
  if (!reader.has(key)) return;
  spec.where = fmt::format("line {}", table.get(key)->source().begin.line);
  if (spec.file.empty()) reader.fail_at(key, "'{}' is empty: name an image, PNG or JPEG", key);
}

// Error: a pair of numbers without its image, or an image without its numbers.
void require_both(TableReader& reader, std::string_view image, std::string_view numbers) {
  if (reader.has(image) && !reader.has(numbers)) reader.fail_at(image, "'{}' needs '{}': the number at black and at white", image, numbers);
  if (reader.has(numbers) && !reader.has(image)) reader.fail_at(numbers, "'{}' has no effect without '{}'", numbers, image);
}

// Error: a key or a damping that cannot be combined with a relief from an image.
void reject_other_bumps(TableReader& reader, std::string_view image, const Material& material) {
  for (const char* key : {"bump_length_m", "bump_pattern", "bump_direction"}) {
    if (reader.has(key)) reader.fail_at(key, "'{}' belongs to bumps by a formula: leave it out, or leave out '{}'", key, image);
  }
  if (material.damping_ns_per_m > 0.0) {
    reader.fail_at(image,
                   "'{}' is set beside 'damping_ns_per_m' = {}: bumps would turn its damping into a source of energy; set that to 0, "
                   "or use 'viscosity_ns_per_m'",
                   image, material.damping_ns_per_m);
  }
}

// Reads normal_map: an image file, or true for the mesh's own normal map.
void read_normals(const toml::table& table, TableReader& reader, const Material& material, MapSpec& spec) {
  if (reader.has("normal_map_scale") && !reader.has("normal_map")) {
    reader.fail_at("normal_map_scale", "'normal_map_scale' has no effect without 'normal_map'");
  }
  if (!reader.has("normal_map")) return;
  if (reader.has("bump_map")) return reader.fail_at("normal_map", "'normal_map' is set beside 'bump_map': keep one");
  if (reader.has("bump_height_m")) {
    return reader.fail_at("bump_height_m",
                          "'bump_height_m' is set beside 'normal_map', whose slopes give the height: use 'normal_map_scale'");
  }
  if (table.get("normal_map")->is_boolean()) {
    spec.where = fmt::format("line {}", table.get("normal_map")->source().begin.line);
    reader.read("normal_map", spec.is_of_mesh);
    if (!spec.is_of_mesh) return reader.fail_at("normal_map", "'normal_map' is false: leave it out, or give true or an image");
    spec.file = kNormalsOfMesh;
  } else {
    read_file_name(table, reader, "normal_map", spec);
  }
  double scale = 1.0;
  reader.read("normal_map_scale", scale, 0.0, kMapMaxNormalScale, true);
  spec.normal_scale = scale;
  reject_other_bumps(reader, "normal_map", material);
}

void read_height(const toml::table& table, TableReader& reader, const Material& material, MapSpec& spec) {
  read_normals(table, reader, material, spec);
  if (!reader.has("bump_map")) return;
  read_file_name(table, reader, "bump_map", spec);
  if (!reader.has("bump_height_m")) reader.fail_at("bump_map", "'bump_map' needs 'bump_height_m': from black to white");
  double height_m = 0.0;
  reader.read("bump_height_m", height_m, 0.0, kMapMaxHeightM, true);
  spec.at_black = -height_m;
  reject_other_bumps(reader, "bump_map", material);
}

void read_stiffness(const toml::table& table, TableReader& reader, Material& material, const SurfaceEffects& effects, MapSpec& spec) {
  read_file_name(table, reader, "stiffness_map", spec);
  require_both(reader, "stiffness_map", "stiffness_map_n_per_m");
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
  require_both(reader, "friction_map", "friction_map_range");
  if (!reader.has("friction_map")) return;
  if (material.friction_static > 0.0) {
    reader.fail_at("friction_map", "'friction_map' replaces 'friction_static' and 'friction_dynamic': leave these out");
  }
  std::array<double, 2> range = {};
  reader.read("friction_map_range", range, 0.0, kFrictionStaticLimit.most);
  spec.at_black = range[0];
  spec.at_white = range[1];
}

void read_viscosity(const toml::table& table, TableReader& reader, const SurfaceEffects& effects, MapSpec& spec) {
  read_file_name(table, reader, "viscosity_map", spec);
  require_both(reader, "viscosity_map", "viscosity_map_ns_per_m");
  if (!reader.has("viscosity_map")) return;
  if (effects.viscosity.is_on()) reader.fail_at("viscosity_map", "'viscosity_map' replaces 'viscosity_ns_per_m': leave that out");
  std::array<double, 2> range = {};
  reader.read("viscosity_map_ns_per_m", range, 0.0, kMapMaxViscosity);
  spec.at_black = range[0];
  spec.at_white = range[1];
}

std::string_view key_of_height(const MapSpec& spec) { return spec.normal_scale ? "normal_map" : "bump_map"; }

// Width and height of the images on the surface, m, from the mean gradients of the texture coordinates. Pre: these have an area.
Eigen::Vector2d find_image_size(const std::vector<MappedTriangle>& triangles) {
  double area = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const MappedTriangle& triangle : triangles) {
    const double weight = (triangle.corner[1] - triangle.corner[0]).cross(triangle.corner[2] - triangle.corner[0]).norm();
    const MapPlace place = map_gradients(triangle);
    area += weight;
    sum += weight * Eigen::Vector2d(place.du.norm(), place.dv.norm());
  }
  return area * sum.cwiseInverse();
}

// The length without its last bits, in which objects that share a mesh may differ because of their poses.
double to_key(double length_m) {
  constexpr int kBits = 40;  // heights keep 24
  if (!std::isfinite(length_m)) return 0.0;
  int exponent = 0;
  const double mantissa = std::frexp(length_m, &exponent);
  return std::ldexp(std::round(std::ldexp(mantissa, kBits)), exponent - kBits);
}

// The material whose normal map all triangles of the mesh use. Error: a triangle has none, or the triangles use several.
Result<const VisualMaterial*> find_normals(const MeshAppearance& appearance, const std::string& object) {
  const VisualMaterial* found = nullptr;
  for (const TriangleAppearance& triangle : appearance.triangles) {
    const VisualMaterial* material =
        triangle.material == TriangleAppearance::kNoMaterial ? nullptr : &appearance.materials[triangle.material];
    if (material == nullptr || !material->normals)
      return fail("the mesh of object '{}' has no normal map, or not everywhere: name an image", printable(object));
    if (found != nullptr && (found->normals != material->normals || found->normal_scale != material->normal_scale)) {
      return fail("the mesh of object '{}' has several normal maps: name an image, or make an object of each 'part'", printable(object));
    }
    found = material;
  }
  return found;
}

std::vector<MappedTriangle> place_triangles(const MapSource& source, const std::array<double, 2>& repeat) {
  std::vector<MappedTriangle> triangles;
  if (source.appearance == nullptr || !source.appearance->has_texcoords() ||
      source.appearance->triangles.size() != source.mesh->triangles.size())
    return triangles;
  const Eigen::Vector2d times(repeat[0], repeat[1]);
  for (std::size_t t = 0; t < source.mesh->triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = source.vertices[source.mesh->triangles[t][k]];
      made.texcoord[k] = source.appearance->triangles[t].corners[k].texcoord.cast<double>().cwiseProduct(times);
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
  read_viscosity(table, reader, effects, specs.viscosity);
  reader.read("map_repeat", specs.repeat, 1.0 / kMapMaxRepeat, kMapMaxRepeat);
  if (reader.has("map_repeat") && !specs.any()) reader.fail_at("map_repeat", "'map_repeat' has no effect without a map");
}

std::filesystem::path MapMaker::shown_path(const MapSpec& spec) const {
  return spec.bytes != nullptr || spec.is_of_mesh ? std::filesystem::path(spec.file) : (folder_ / spec.file).lexically_normal();
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

Result<ImageMap> MapMaker::make_relief(const MapSpec& spec, const MapSource& source, const std::vector<MappedTriangle>& triangles,
                                       const std::string& object) {
  double scale = *spec.normal_scale;
  std::size_t number = 0;
  if (spec.is_of_mesh) {
    const auto material = find_normals(*source.appearance, object);
    if (!material) return fail("{}: 'normal_map': {}", spec.where, material.error().what);
    number = *(*material)->normals;
    scale *= (*material)->normal_scale;
  }
  const Eigen::Vector2d size_m = find_image_size(triangles);
  const ReliefKey key(shown_path(spec).string(), spec.is_of_mesh ? source.appearance : nullptr, number, to_key(size_m.x()),
                      to_key(size_m.y()), scale);
  if (const auto found = reliefs_.find(key); found != reliefs_.end()) return found->second;
  TextureImage image{.name = shown_path(spec).string(), .bytes = {}};
  if (spec.is_of_mesh) {
    image = source.appearance->images[number];
  } else {
    auto bytes = read_image_bytes(shown_path(spec));
    if (!bytes) return fail("{}: 'normal_map': {}", spec.where, bytes.error().what);
    image.bytes = std::move(*bytes);
  }
  auto relief = decode_image(image.bytes, TexelKind::numbers).and_then([&](const ImageTexels& texels) {
    return relief_of_normals(texels, size_m, scale);
  });
  if (!relief) return fail("{}: 'normal_map': {}: {}", spec.where, image.name, relief.error().what);
  if (!(relief->height_m <= kMapMaxHeightM)) {
    return fail("{}: 'normal_map': {}: its relief is {:.3g} m high, and {} m are the most: lower 'normal_map_scale'{}", spec.where,
                image.name, relief->height_m, kMapMaxHeightM, spec.is_of_mesh ? ", or the scale of normalTexture in the mesh file" : "");
  }
  const ImageMap made{
      .image = std::make_shared<const SurfaceImage>(std::move(relief->image)), .at_black = -relief->height_m, .at_white = 0.0};
  return reliefs_.emplace(key, made).first->second;
}

std::shared_ptr<const SurfaceImage> MapMaker::halve(const std::shared_ptr<const SurfaceImage>& image) {
  auto& half = halves_[image];
  if (half == nullptr) half = std::make_shared<const SurfaceImage>(image->halved());
  return half;
}

Result<SurfaceMaps> MapMaker::make(const MapSpecs& specs, const MapSource& source, const std::string& object,
                                   std::vector<std::string>& notes) {
  SurfaceMaps maps;
  const struct {
    const MapSpec& spec;
    std::string_view key;
    ImageMap& map;
  } all[] = {{specs.height, key_of_height(specs.height), maps.height},
             {specs.stiffness, "stiffness_map", maps.stiffness},
             {specs.friction, "friction_map", maps.friction},
             {specs.viscosity, "viscosity_map", maps.viscosity}};
  auto triangles = place_triangles(source, specs.repeat);
  if (triangles.empty()) {
    const auto* first = std::ranges::find_if(all, [](const auto& one) { return !one.spec.file.empty(); });
    return fail("{}: '{}' needs texture coordinates, and the mesh of object '{}' has none: unwrap it", first->spec.where, first->key,
                printable(object));
  }
  maps.triangles = std::make_shared<const std::vector<MappedTriangle>>(std::move(triangles));
  for (const auto& one : all) {
    auto map = one.spec.normal_scale ? make_relief(one.spec, source, *maps.triangles, object) : make_map(one.spec, one.key);
    if (!map) return tl::unexpected(map.error());
    one.map = std::move(*map);
  }
  if (!maps.height.is_on()) return maps;
  const double given = maps.height.steepest(*maps.triangles);
  for (double slope = given; slope > SurfaceMaps::kSteepest; slope = maps.height.steepest(*maps.triangles)) {
    maps.height.image = halve(maps.height.image);
  }
  if (given > SurfaceMaps::kSteepest) {
    notes.push_back(fmt::format("{}: object '{}': bumps of slope {:.3g}, above {}, are smoothed to {} x {} texels; a lower {} keeps them",
                                shown_path(specs.height).string(), printable(object), given, SurfaceMaps::kSteepest,
                                maps.height.image->width(), maps.height.image->height(),
                                specs.height.normal_scale ? "normal_map_scale" : "bump_height_m"));
  }
  return maps;
}

}  // namespace hapton
