#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// One sample for which a force command came: positions of the device and of the drawn probe, and the force. Frame W, m, N.
struct DemoSample {
  std::int64_t time_ns = 0;  // when the device was sampled
  Vec3 p_WD = Vec3::Zero();
  Vec3 p_WP = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  bool contact = false;
};

// The force that the motors got in one cycle.
struct DemoForceWritten {
  std::int64_t time_ns = 0;
  double newtons = 0.0;
};

// Device, probe and force from a recording (io_node --record). Times are of the hub's clock, which is the clock of this machine.
struct DemoMotion {
  std::vector<DemoSample> steps;
  std::vector<DemoForceWritten> written_forces;
};

// Error, one line: the file is not a recording, or it is truncated or damaged. RT: no.
Result<DemoMotion> read_demo_motion(const std::filesystem::path& recording);

}  // namespace hapton
