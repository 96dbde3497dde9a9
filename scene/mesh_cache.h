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

// The meshes of a scene file: each mesh file is read once, and each of its parts prepared for touch once, however many objects use it. All
// files have kMaxMeshTriangles at most, and so have all objects: as many as a file alone may have. RT: set-up only. Error, of all
// functions: one line with the number of the line in the scene file.
class MeshCache {
 public:
  struct ReadyMesh {
    TriangleMesh mesh;
    SealReport sealed;
    std::vector<Vec3> vertices_before;  // the vertices before it was sealed; empty: it was not
    std::uint64_t given_hash = 0;
    std::shared_ptr<const MeshAppearance> appearance;  // null: none
    MapSource map;                                     // if there are maps: the mesh before it was sealed
  };

  // maps: what the maps of the scene (images for forces) need of mesh files, even if `appearance` is off.
  MeshCache(CrackSealing sealing, AppearanceReading appearance, AppearanceReading maps)
      : sealing_(sealing), appearance_(appearance), maps_(maps) {}

  // The mesh that the object names: a part of a file, some of its nodes, or all of it. notes: gets lines for the log.
  Result<const ReadyMesh*> load(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes);
  // Counts the triangles of one more object, of the mesh that it names: each object has its own. folder: of the scene file. Error: that
  // mesh cannot be loaded, or all objects so far have too many.
  Result<void> count(const std::filesystem::path& folder, const ObjectSpec& object, std::vector<std::string>& notes);
  // The whole file.
  Result<const MeshFile*> load_file(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes);

  // The haptic materials in the file, and the numbers of those that the object has. haptics is null if the file has none.
  struct HapticChoice {
    const MeshHaptics* haptics = nullptr;
    std::vector<std::uint32_t> materials = {};
  };
  Result<HapticChoice> find_haptics(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes);
  // One of these materials, read once, so that all objects that have it share its images. path: of its file. Valid as long as this.
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
