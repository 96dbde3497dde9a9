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

// Results of a touch that the real programs (io_node, haptics_node, hapton relay) carried out and that the hub recorded, as opposed to the
// simulated touch of remote_run.h.
struct RecordedTouch {
  ForceComparison force;
  RemoteRates rates;               // from RecordedRun::from_s to to_s
  double scene_kb = 0.0;           // size of all parts of the scene that the hub received, repeated ones included
  double ready_s = 0.0;            // time from the first sample to the last part of the scene, repeated or not
  double local_share = 0;          // share of the cycles in contact whose force was computed by io_node, at the device
  double local_error_rms = 0.0;    // RMS error of those forces, before the governor, as a share of the RMS zero-delay force
  double local_error_max_n = 0.0;  // largest error of those forces
  std::uint64_t cycles = 0;        // cycles with a sample of the device
  std::uint64_t missed = 0;        // cycles that the hub left out
};

struct RecordedRun {
  double from_s = 0.0;  // time since the first sample; from here the hand slides and rests ...
  double to_s = 0.0;    // ... up to here
  double period_s = 1e-3;
  double most_late_s = 0.1;                                      // the delay of the force is found by trying delays up to this
  double max_force_n = std::numeric_limits<double>::infinity();  // of the device
};

// Compares the force that was written to the motors in each cycle with the force of the whole scene at the same sample, without delay.
// `method` is reset. RecordedTouch::rates counts packets that the hub sent as up, and those that it received as down. Error, one line:
// the file is not a recording, it breaks off, or it has no samples of the device. RT: no.
Result<RecordedTouch> evaluate_recording(const std::filesystem::path& recording, std::shared_ptr<ForceMethod> method,
                                         const RecordedRun& run);

}  // namespace hapton
