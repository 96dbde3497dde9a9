#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/mesh_report.h"
#include "scene/scene_file.h"

namespace hapton {

struct SceneLayout;

// What `hapton info` reports about a scene file: the meshes in their poses, as they are touched; metres, frame S.
struct SceneReport {
  std::string path;
  Scene scene;
  std::vector<MeshFlaws> flaws;               // one for each object
  std::shared_ptr<const SceneLayout> layout;  // how the scene file is laid out
};

// Error: whatever load_scene rejects. RT: set-up only.
Result<SceneReport> make_scene_report(const std::filesystem::path& path);

// One line for each object that has a closed body which is inside out. RT: set-up only.
std::vector<std::string> find_inside_out(const Scene& scene);

// Text for users: two lines for each object, then a line for each of the other tables.
std::string to_text(const SceneReport& report);

// One JSON object with a schema version.
std::string to_json(const SceneReport& report);

}  // namespace hapton
