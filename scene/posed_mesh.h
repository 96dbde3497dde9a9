#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/map_reader.h"
#include "scene/mesh_cache.h"
#include "scene/object_reader.h"
#include "scene/scene_fit.h"
#include "scene/touch_mesh.h"

namespace hapton {

// A mesh in the pose that a scene file gives it. Frame: S; apply_fit moves `mesh`, `sealed`, `map` and `unsealed_vertices`.
struct PosedMesh {
  TriangleMesh mesh;
  SealReport sealed;
  Eigen::AlignedBox3d box;       // box of the mesh before cracks were sealed, and before the fit
  std::uint64_t given_hash = 0;  // hash of the mesh before sealing, and of its pose
  std::shared_ptr<const MeshAppearance> appearance;
  MapSource map = {};                        // if there are maps
  std::vector<Vec3> in_file = {};            // if an animation deforms it: the vertices in the file's frame, before the pose
  std::vector<Vec3> unsealed_vertices = {};  // if morphs of the scene file deform it, and cracks were sealed: the vertices before that
};

// folder: that of the scene file. notes: receives lines for the log. Error: as MeshCache::load. RT: set-up only.
Result<PosedMesh> make_posed_mesh(const ObjectSpec& object, const std::filesystem::path& folder, MeshCache& cache,
                                  std::vector<std::string>& notes);

void apply_fit(const SceneFit& fit, std::vector<PosedMesh>& meshes);

}  // namespace hapton
