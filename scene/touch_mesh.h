#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/seal_cracks.h"
#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_appearance.h"
#include "scene/unit.h"

namespace hapton {

// Whether cracks and T-junctions up to kSealedShare of a mesh's longest side are sealed before it is touched (core/geometry/seal_cracks.h).
enum class CrackSealing { on, off };

// With sealing off, the mesh is unchanged and the report empty. RT: set-up only.
SealReport seal_for_touch(TriangleMesh& mesh, CrackSealing sealing = CrackSealing::on);

// A mesh file as loaded for touch.
struct TouchMesh {
  TriangleMesh mesh;  // metres, the file's own frame
  SealReport sealed;
  std::uint64_t given_hash = 0;    // hash_mesh() of the mesh as its file gives it
  std::vector<std::string> notes;  // what was sealed, skipped or is suspicious, one line each
  bool has_haptics = false;        // some triangles have a material of MPEG_haptic_material (glTF)
  Eigen::AlignedBox3d box = {};    // of the mesh before sealing, which may move its outermost vertices
  MeshAppearance appearance;       // without triangles if not requested, or if the mesh was sealed, which changes its triangles
};

// Error: whatever load_mesh_file rejects. RT: set-up only.
Result<TouchMesh> load_touch_mesh(const std::filesystem::path& path, std::optional<Unit> unit = std::nullopt,
                                  CrackSealing sealing = CrackSealing::on, AppearanceReading appearance = AppearanceReading::off);

}  // namespace hapton
