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

// How a scene file is laid out, as written there: load_scene makes plain objects of it, in which it cannot be seen any more.
struct SceneLayout {
  std::optional<Vec3> fit_m;  // none: there is no such key
  std::optional<Similarity> workspace;
  std::vector<GroupSpec> groups;
  std::vector<GroupSpec> instances;
  std::vector<ProbeSpec> probes;
  // Findings of `hapton check` that an object accepts (scene/accepted_findings.h), by SceneObject::line; an instance has that of its
  // object.
  std::map<std::size_t, std::vector<std::string>> accepted;
};

// RT: set-up only. Error: the file cannot be read, or what these tables have is rejected by load_scene too: one line.
Result<SceneLayout> read_layout(const std::filesystem::path& scene_file);

}  // namespace hapton
