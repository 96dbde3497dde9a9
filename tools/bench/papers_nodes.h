#pragma once

#include <filesystem>

#include "bench/papers/papers_report.h"

namespace hapton {

struct PapersNodesSettings {
  std::filesystem::path out;    // for the nodes' logs and reports
  std::filesystem::path scene;  // the memo's car
  int frames = 200;             // drawn for each stereo rate
  double seconds = 10.0;        // of the whole system, for round trip and system latency
};

// Fills in the memo's rows that need running nodes: stereo rates from vision_node --bench-frames with --cull-open and with --no-cull, round
// trip and system latency from a run of all three nodes. Where a node is not built or nothing can be drawn, its row stays without a value
// and says why. RT: set-up only.
void measure_paper_nodes(const PapersNodesSettings& settings, PapersReport& report);

}  // namespace hapton
