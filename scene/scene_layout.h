#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"
#include "scene/group_reader.h"
#include "scene/probe_reader.h"
#include "scene/similarity.h"

namespace hapton {

// The parts of a scene file that are no longer visible in what load_scene makes of it, which are plain objects.
struct SceneLayout {
  std::optional<Vec3> fit_m;  // none: the file has no such key
  std::optional<Similarity> workspace;
  std::vector<GroupSpec> groups;
  std::vector<GroupSpec> instances;
  std::vector<ProbeSpec> probes;
  // The findings of `hapton check` that an object accepts (scene/accepted_findings.h). Key: SceneObject::line; an instance has the line of
  // its object.
  std::map<std::size_t, std::vector<std::string>> accepted;
};

// Reads the layout. RT: set-up only. Error, one line: the file cannot be read, or has values in these tables that load_scene rejects too.
Result<SceneLayout> read_layout(const std::filesystem::path& scene_file);

}  // namespace hapton
