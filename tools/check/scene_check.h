#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"
#include "tools/check/step_cost.h"
#include "tools/loop/loop_flags.h"

namespace hapton {

// The devices, hands, probe and servo loop that the scene is checked against.
struct SceneCheckSettings {
  std::vector<NamedLoop> loops;  // every device with every hand; at least one
  double probe_radius_m = 0.0;
  double rate_hz = 1000.0;
  double delay_s = 5e-4;  // the time from a sample to its force
  std::uint64_t seed = 1;
  std::map<std::size_t, std::vector<std::string>> accepted = {};  // the findings that an object accepts, see SceneLayout::accepted
};

struct SceneCheck {
  std::string path;
  CheckFindings findings;          // those of each object in turn, then those of effects, tool and whole scene
  CheckFindings accepted;          // findings that the scene file accepts; the notes name them, too
  std::vector<std::string> notes;  // what was not checked, what was accepted, and the notes of the loader
  std::size_t objects = 0;
  std::size_t triangles = 0;
  StepCost cost;
};

// Checks a loaded scene. Error: the force method, or its rigid tool, rejects it. RT: no; some seconds for a large scene.
Result<SceneCheck> check_scene(const std::string& path, const Scene& scene, const SceneCheckSettings& settings);

// The check as text for people: for each finding a line "FILE: object 'NAME' at (x, y, z) m: WHAT; FIX", then the notes and a summary.
std::string to_text(const SceneCheck& check, const SceneCheckSettings& settings);

// The check as one JSON object, schema hapton.scene_check/2.
std::string to_json(const SceneCheck& check, const SceneCheckSettings& settings);

}  // namespace hapton
