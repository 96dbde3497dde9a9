#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "remote_touch/force_comparison.h"
#include "remote_touch/remote_run.h"

namespace hapton {

// A touch over real processes, from the hub's recording.
struct RecordedTouch {
  ForceComparison force;
  RemoteRates rates;             // between the two times given
  double scene_kb = 0.0;         // parts of the scene, in all
  double ready_s = 0.0;          // from the first sample to the last new part of the scene
  double local_share = 0;        // of the cycles in contact: computed beside the device
  double local_error_rms = 0.0;  // of those forces, before the governor: share of the zero-delay force
  double local_error_max_n = 0.0;
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;  // cycles left out
};

struct RecordedRun {
  double from_s = 0.0;  // the hand slides and rests from here, since the first sample, ...
  double to_s = 0.0;    // ... to here
  double period_s = 1e-3;
  double most_late_s = 0.1;                                      // that a force is taken to be late by
  double max_force_n = std::numeric_limits<double>::infinity();  // of the device
};

// Holds what went to the motors in each cycle against the force of the whole scene at the same sample, without delay. `method` is reset.
// Packets are those that the hub sent, and those that reached it. Error: one line: not a recording, it breaks off, or it has no samples of
// the device. RT: no.
Result<RecordedTouch> evaluate_recording(const std::filesystem::path& recording, std::shared_ptr<ForceMethod> method,
                                         const RecordedRun& run);

}  // namespace hapton
