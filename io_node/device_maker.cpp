#include "io_node/device_maker.h"

#include "io_node/devices/replay_device.h"
#include "io_node/devices/simulated_phantom.h"

namespace hapton {

Result<std::unique_ptr<Device>> make_device(const IoOptions& options) {
  if (options.device == "simulated") {
    if (!options.trajectory.empty()) return fail("--trajectory goes with --device replay; add that or leave the trajectory out");
    return std::make_unique<SimulatedPhantom>(SimulatedPhantom::Options{.seed = options.seed, .stylus = {}});
  }
  if (options.device == "replay") {
    if (options.trajectory.empty()) return fail("--device replay needs --trajectory FILE");
    auto rows = read_trajectory_csv(options.trajectory);
    if (!rows) return tl::unexpected(rows.error());
    return std::make_unique<ReplayDevice>(std::move(*rows), ReplayDevice::Options{.loop = options.loop});
  }
  return fail("there is no device '{}'; take simulated or replay", options.device);
}

}  // namespace hapton
