// Any bytes as the --config file of a node.
#include <array>
#include <cmath>

#include "io_node/io_options.h"
#include "tests/fuzz/input_file.h"

FUZZ_TARGET(config) {
  using namespace hapton;
  static fuzz::InputFile file("io.toml");
  const std::string path = file.write(bytes).string();
  const std::array<const char*, 3> argv = {"io_node", "--config", path.c_str()};
  const auto parsed = parse_io_options(static_cast<int>(argv.size()), argv.data());
  if (const int* code = std::get_if<int>(&parsed)) {
    fuzz::require(*code == 2);  // a file cannot ask for help
    return;
  }
  const auto& options = std::get<IoOptions>(parsed);
  fuzz::require(options.rate_hz >= 250.0 && options.rate_hz <= 10'000.0);
  fuzz::require(std::isfinite(options.seconds) && options.seconds >= 0.0);
  fuzz::require(options.device.max_force_n >= 0.0 && std::isfinite(options.device.max_slew_n_per_s));  // infinite: the device's own limit
}
