#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "core/base/result.h"
#include "core/effects/surface_effects.h"
#include "core/force/touch_scene.h"
#include "scene/mesh_appearance.h"
#include "scene/table_reader.h"

namespace hapton {

// A map of a material as its table gives it: the values at black and at white, and an image file beside the scene or in a mesh file.
struct MapSpec {
  std::string file;   // name of the image file; for an image in a mesh file the name that messages show; empty: no map
  std::string where;  // place of the map that errors name: "line 7"
  std::shared_ptr<const std::string> bytes = {};  // content of an image in a mesh file; null: a file beside the scene
  double at_black = 0.0;
  double at_white = 0.0;
  // For a height map that is given as a normal map: the factor of its slopes, and at_black is computed from it. None: every other map.
  std::optional<double> normal_scale = {};
  bool is_of_mesh = false;  // the normal map is that of the object's mesh file
};

struct MapSpecs {
  MapSpec height;                             // m
  MapSpec stiffness;                          // share of the material's stiffness
  MapSpec friction;                           // coefficient
  MapSpec viscosity;                          // Ns/m
  std::array<double, 2> repeat = {1.0, 1.0};  // repetitions of the images, along u and v

  bool any() const { return !height.file.empty() || !stiffness.file.empty() || !friction.file.empty() || !viscosity.file.empty(); }
  // What has to be read from a mesh file for these maps.
  AppearanceReading reading() const {
    return !any() ? AppearanceReading::off : height.is_of_mesh ? AppearanceReading::with_normals : AppearanceReading::on;
  }
};

// The keys of [material.NAME] for maps. docs/effects.md describes each of them and its range.
std::span<const std::string_view> map_keys();

// Reads these keys. The stiffness of a material with a stiffness map becomes the largest value of the map. The reader keeps the error:
// values out of range, a key whose map is missing, or a map beside a property of the material (`effects`) that excludes it. RT: set-up
// only.
void read_maps(const toml::table& table, TableReader& reader, Material& material, const SurfaceEffects& effects, MapSpecs& specs);

// A mesh with its texture coordinates, in the frame of the scene.
struct MapSource {
  std::vector<Vec3> vertices;
  std::shared_ptr<const TriangleMesh> mesh;          // the triangles of `vertices`
  std::shared_ptr<const MeshAppearance> appearance;  // one entry for each triangle; null: no texture coordinates
};

// Makes the maps of objects. Objects with equal maps share them. Images are read once, normal maps once for each size on the surface and
// slope factor.
class MapMaker {
 public:
  explicit MapMaker(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // object: its name. If the slope of a height map exceeds SurfaceMaps::kSteepest, its resolution is halved until the slope does not, and
  // notes gets a line. Error, with the place of the map: an image that cannot be read; a mesh without texture coordinates. RT: set-up only.
  Result<SurfaceMaps> make(const MapSpecs& specs, const MapSource& source, const std::string& object, std::vector<std::string>& notes);

 private:
  std::filesystem::path shown_path(const MapSpec& spec) const;
  Result<ImageMap> make_map(const MapSpec& spec, std::string_view key);
  // Heights that are computed from a normal map.
  Result<ImageMap> make_relief(const MapSpec& spec, const MapSource& source, const std::vector<MappedTriangle>& triangles,
                               const std::string& object);
  std::shared_ptr<const SurfaceImage> halve(const std::shared_ptr<const SurfaceImage>& image);

  // The file, or the mesh and the number of its image; width and height of the image on the surface, rounded; the factor of its slopes.
  using ReliefKey = std::tuple<std::string, std::shared_ptr<const MeshAppearance>, std::size_t, double, double, double>;

  std::filesystem::path folder_;
  std::map<std::string, std::shared_ptr<const SurfaceImage>> images_;  // by file
  std::map<ReliefKey, ImageMap> reliefs_;
  std::map<std::shared_ptr<const SurfaceImage>, std::shared_ptr<const SurfaceImage>> halves_;  // key: the image with twice the resolution
};

}  // namespace hapton
