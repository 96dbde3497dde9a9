// Any bytes as the --devices file of an io_node.
#include "io_node/devices_file.h"
#include "tests/fuzz/input_file.h"

FUZZ_TARGET(devices) {
  using namespace hapton;
  static fuzz::InputFile file("devices.toml");
  const auto devices = read_devices_file(file.write(bytes), {});
  if (!devices) {
    fuzz::require(!devices.error().what.empty());
    fuzz::require(devices.error().what.find('\n') == std::string::npos);
    return;
  }
  fuzz::require(!devices->empty());
  for (const IoOptions& options : *devices) {
    fuzz::require(!options.name.empty() && options.name.find('/') == std::string::npos);
    fuzz::require(options.rate_hz >= 250.0 && options.rate_hz <= 10'000.0);
    fuzz::require(options.device.X_WB.matrix().allFinite());
    fuzz::require((options.device.X_WB.linear() * options.device.X_WB.linear().transpose()).isApprox(Mat3::Identity(), 1e-9));
    fuzz::require(options.device.max_force_n >= 0.0 && options.device.max_slew_n_per_s >= 0.0);
  }
}
