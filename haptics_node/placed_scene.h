#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/sculpt/carve_list.h"
#include "haptic_step/haptics_step.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"

namespace hapton {

// The mesh, with its vertices and normals moved by X.
TriangleMesh move_mesh(const Pose& X, const TriangleMesh& mesh);

// Places an object, with all that is fixed to its surface, where X moves it from the place that it has in the scene file. as_loaded: the
// same object at that place.
void move_object(const Pose& X, const SceneObject& as_loaded, SceneObject& object);

// The movable objects that an annotations file has at another place than the scene file, and their poses; empty if `file` is empty or does
// not exist yet. Objects that are not movable in the scene are left out, with a line in the log. Error: whatever read_annotations rejects.
// RT: no.
Result<std::vector<PutDown>> read_saved_poses(const std::filesystem::path& file, const Scene& scene);

// The carves that the same file has, of objects that can be carved in the scene. Those of other objects are left out, with a line in the
// log. Error: as above. RT: no.
Result<std::vector<CarvedPress>> read_saved_carves(const std::filesystem::path& file, const Scene& scene);

// Applies these carves to the bodies of the step, before its first reply. Returns the list of what was carved, without carves that change
// nothing.
std::vector<MadeCarve> apply_saved_carves(const std::vector<CarvedPress>& carved, HapticsStep& step);

// The scene with these objects where they were put down. Pre: the objects are of the scene.
Scene place_objects(const Scene& scene, const std::vector<PutDown>& put_down);

}  // namespace hapton
