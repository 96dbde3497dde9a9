#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/sculpt/carve_list.h"
#include "haptic_step/haptics_step.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"

namespace hapton {

// Returns the mesh with its vertices moved and its normals turned by X.
TriangleMesh move_mesh(const Pose& X, const TriangleMesh& mesh);

// Moves an object, with all that is fixed to its surface, by X from its place in the scene file. as_loaded: the same object at that place;
// frame S.
void move_object(const Pose& X, const SceneObject& as_loaded, SceneObject& object);

// Reads from an annotations file which movable objects lie at another place than in the scene file, and their poses; empty if `file` is
// empty or does not exist yet. Objects that are not movable in the scene are left out, with a line in the log. Error: as read_annotations.
// RT: no.
Result<std::vector<PutDown>> read_saved_poses(const std::filesystem::path& file, const Scene& scene);

// Reads the carves of objects that can be carved in the scene from the same file. Those of other objects are left out, with a line in the
// log. Error: as read_annotations. RT: no.
Result<std::vector<CarvedPress>> read_saved_carves(const std::filesystem::path& file, const Scene& scene);

// Applies these carves to the bodies of the step, before its first reply. Returns the carves that were made, without those that change
// nothing. RT: set-up only.
std::vector<MadeCarve> apply_saved_carves(const std::vector<CarvedPress>& carved, HapticsStep& step);

// Returns the scene with these objects where they were put down. Pre: each PutDown::object is the number of an object of the scene.
Scene place_objects(const Scene& scene, const std::vector<PutDown>& put_down);

}  // namespace hapton
