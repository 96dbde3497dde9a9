#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/sculpt/carve_list.h"
#include "haptic_step/haptics_step.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"

namespace hapton {

// A mesh and its normals, moved.
TriangleMesh move_mesh(const Pose& X, const TriangleMesh& mesh);

// Puts an object there, with all that is fixed to its surface. as_loaded: the same object where the scene file has it, from which X leads.
void move_object(const Pose& X, const SceneObject& as_loaded, SceneObject& object);

// The movable objects that a file of annotations says to lie elsewhere, and where; nothing where there is no such file yet, or none is
// named. Objects that the scene does not let move are left out, with a line in the log. Error: whatever read_annotations rejects. RT: no.
Result<std::vector<PutDown>> read_put_down(const std::filesystem::path& file, const Scene& scene);

// What the same file says to be carved from objects that the scene lets the stylus carve. Objects that it does not are left out, with a
// line in the log. Error: as above. RT: no.
Result<std::vector<CarvedPress>> read_carved(const std::filesystem::path& file, const Scene& scene);

// Carves the bodies of the step so, before its first reply. Returns the list of what was carved; carves that change nothing are not in it.
std::vector<MadeCarve> carve_as_saved(const std::vector<CarvedPress>& carved, HapticsStep& step);

// The scene with those objects there. Pre: they are of the scene.
Scene place_objects(const Scene& scene, const std::vector<PutDown>& put_down);

}  // namespace hapton
