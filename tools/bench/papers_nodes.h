#pragma once

#include <filesystem>

#include "bench/papers/papers_report.h"

namespace hapton {

struct PapersNodesSettings {
  std::filesystem::path out;    // folder of the nodes' logs and reports
  std::filesystem::path scene;  // scene file of the HP memo's car
  int frames = 200;             // frames to draw for each stereo rate
  double seconds = 10.0;        // duration of the run of the whole system that measures round trip and system latency
};

// Fills in the rows of the HP memo (docs/glossary.md) that need running nodes: stereo rates from vision_node --bench-frames, once with
// --cull-open and once with --no-cull; round trip and system latency from a run of all three nodes. If a node is not built or nothing can
// be drawn, its row has no value and gives the reason. RT: no.
void measure_paper_nodes(const PapersNodesSettings& settings, PapersReport& report);

}  // namespace hapton
