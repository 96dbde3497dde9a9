#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/touch_scene.h"
#include "core/geometry/triangle_mesh.h"
#include "scene/scene_loading.h"

namespace hapton {

// One thing that is seen and touched.
struct SceneObject {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  // frame S, metres, pose and scale baked in
  Material material;
  std::array<double, 3> colour = {0.7, 0.7, 0.72};  // sRGB, 0..1
  SealReport sealed = {};                           // what was done to the mesh, its widths in S
  std::shared_ptr<const MeshLook> look = {};        // of the mesh file, in place of the colour; null: none
};

// All that is seen and touched. Frame S.
struct Scene {
  std::vector<SceneObject> objects;  // at least one
  std::vector<std::string> notes;    // what was skipped or looks odd, one line each
  // Of the meshes as the files have them, their poses and their fit: the same wherever these are, sealed or not. Not 0.
  std::uint64_t given_hash = 0;

  // The same meshes, not copies, as the force methods want them.
  TouchScene touch_scene() const;
};

// Reads a scene file (TOML, docs/scene-files.md has every key) or a plain mesh file, which makes a scene of one object.
// loading.sealing off leaves the cracks of every mesh as they are; a scene file can also say so of one object. Either way
// everything else is in the same place: the scene is fitted to the meshes before sealing. Error: one line with the file, the
// line in it and what to do: unknown keys with the nearest known one, values out of their range, whatever load_mesh_file
// rejects.
Result<Scene> load_scene(const std::filesystem::path& path, const SceneLoading& loading = {});

}  // namespace hapton
