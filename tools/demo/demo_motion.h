#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// One step with a reply: positions of the device and of the drawn probe, and the force. W, m, N.
struct DemoStepSeen {
  std::int64_t time_ns = 0;  // of the device's sample
  Vec3 p_WD = Vec3::Zero();
  Vec3 p_WP = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  bool contact = false;
};

// What went to the motors in one cycle.
struct DemoForceWritten {
  std::int64_t time_ns = 0;
  double newtons = 0.0;
};

// Hand, probe and force from a recording (io_node --record). Times: the hub's clock, which is this machine's.
struct DemoMotion {
  std::vector<DemoStepSeen> steps;
  std::vector<DemoForceWritten> written;
};

// Error: one line: not a recording, or it breaks off. RT: no.
Result<DemoMotion> read_demo_motion(const std::filesystem::path& recording);

}  // namespace hapton
