#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"

namespace hapton {

// A mesh and its normals, moved.
TriangleMesh move_mesh(const Pose& X, const TriangleMesh& mesh);

// The movable objects that a file of annotations says to lie elsewhere, and where; nothing where there is no such file yet, or none is
// named. Objects that the scene does not let move are left out, with a line in the log. Error: whatever read_annotations rejects. RT: no.
Result<std::vector<PutDown>> read_put_down(const std::filesystem::path& file, const Scene& scene);

// The scene with those objects there. Pre: they are of the scene.
Scene place_objects(const Scene& scene, const std::vector<PutDown>& put_down);

}  // namespace hapton
