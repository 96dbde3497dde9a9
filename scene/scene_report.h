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

// What `hapton info` reports about a scene file: the meshes as posed and as they are touched, in metres, frame S.
struct SceneReport {
  std::string path;
  Scene scene;
  std::vector<MeshFlaws> flaws;  // one an object
  std::shared_ptr<const SceneLayout> layout;
};

// Error: whatever load_scene rejects. RT: set-up only.
Result<SceneReport> make_scene_report(const std::filesystem::path& path);

// One line for each object of which a closed body is inside out. RT: set-up only.
std::vector<std::string> find_inside_out(const Scene& scene);

// For people, two lines an object, then a line for each of the other tables.
std::string to_text(const SceneReport& report);

// One JSON object with a schema version.
std::string to_json(const SceneReport& report);

}  // namespace hapton
