#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "scene/map_reader.h"
#include "scene/material_reader.h"
#include "scene/mesh_file.h"
#include "scene/object_reader.h"
#include "scene/touch_mesh.h"

namespace hapton {

// The meshes of a scene file: each mesh file is read once, and each of its parts is prepared for touch once, however many objects use it.
// All files together have at most kMaxMeshTriangles, and so have all objects together. RT: set-up only. Error of all functions except
// find_material: one line with the number of the line in the scene file.
class MeshCache {
 public:
  struct ReadyMesh {
    TriangleMesh mesh;
    SealReport sealed;
    std::vector<Vec3> unsealed_vertices;               // vertices before cracks were sealed; empty: none were sealed
    std::uint64_t given_hash = 0;                      // hash_mesh() before sealing
    std::shared_ptr<const MeshAppearance> appearance;  // null: none
    MapSource map;                                     // if there are maps: the mesh before sealing; MapSource::vertices is empty
  };

  // maps: what has to be read from mesh files for the maps of the scene (images for forces), even if `appearance` is off.
  MeshCache(CrackSealing sealing, AppearanceReading appearance, AppearanceReading maps)
      : sealing_(sealing), appearance_(appearance), maps_(maps) {}

  // The mesh that the object names: a part of a file, some of its nodes, or all of it. notes: receives lines for the log.
  Result<const ReadyMesh*> load(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes);
  // Adds the triangles of the mesh of one more object to the count; each object has its own copy. folder: that of the scene file. Error:
  // the mesh cannot be loaded, or all objects so far have too many triangles.
  Result<void> count(const std::filesystem::path& folder, const ObjectSpec& object, std::vector<std::string>& notes);
  // Loads the whole file.
  Result<const MeshFile*> load_file(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes);

  // The haptic materials in the file, and the indices of those that the object's triangles have. haptics: null if the file has none.
  struct HapticChoice {
    const MeshHaptics* haptics = nullptr;
    std::vector<std::uint32_t> materials = {};
  };
  Result<HapticChoice> find_haptics(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes);
  // One of these materials, read once, so that its images are shared. path: the mesh file, for errors. Valid as long as the cache.
  Result<const MaterialSpec*> find_material(const std::filesystem::path& path, const MeshHaptics& haptics, std::uint32_t index);

 private:
  using Key =
      std::tuple<std::string, std::optional<Unit>, std::string, std::vector<std::size_t>, CrackSealing, std::optional<std::uint32_t>>;

  CrackSealing sealing_;
  AppearanceReading appearance_;
  AppearanceReading maps_;
  std::map<std::pair<std::string, std::optional<Unit>>, MeshFile> files_;
  std::map<Key, ReadyMesh> meshes_;
  std::map<std::pair<const MeshHaptics*, std::uint32_t>, MaterialSpec> materials_;
  std::size_t file_triangles_ = 0;
  std::size_t object_triangles_ = 0;
};

}  // namespace hapton
