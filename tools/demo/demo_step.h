#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/demo/demo_path.h"
#include "tools/demo/demo_verdict.h"

namespace hapton {

// One step of the tour: the scene to touch, the path of the hand, and the check of the result.
struct DemoStep {
  enum class Event : std::uint8_t { none, haptics_dies };

  std::string_view name;
  std::string_view watch_for;            // tells the person what to watch, in one or two lines
  std::string_view scene;                // path of the scene file; empty: the generated ball (demo_shapes.h)
  std::vector<std::string> relay = {};   // flags of `hapton relay` between the hub and the haptics node; empty: no relay
  std::vector<std::string> vision = {};  // flags of the step's vision node
  std::string picture_at = "contact";    // when a scripted run takes its picture, see vision_node --screenshot-when
  Event event = Event::none;
  Result<DemoPath> (*make_path)(const Scene& scene) = nullptr;
  DemoVerdict (*evaluate)(const DemoEvidence& evidence) = nullptr;
};

// The steps of the tour, in order; a step's number is its position, from 1. RT: set-up only.
std::span<const DemoStep> demo_steps();

// The base name of the step's files: "1-rest-on-the-car". Pre: there is such a step.
std::string demo_file_name(std::size_t number);

}  // namespace hapton
