#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <thread>
#include <vector>

#include "io_node/device_hub.h"
#include "io_node/devices_file.h"
#include "io_node/io_options.h"
#include "io_node/service_liveness.h"
#include "runtime/descriptor_check.h"
#include "runtime/instruction_set_check.h"
#include "runtime/log.h"
#include "runtime/standard_streams.h"
#include "runtime/start_thread.h"
#include "runtime/stop_signal.h"

namespace {

using namespace hapton;

using Hubs = std::vector<std::unique_ptr<DeviceHub>>;

// Opens a hub for each device. Error if one cannot be opened: to run only some of the devices is not what was requested.
Result<Hubs> open_hubs(const IoOptions& options, const Clock& clock) {
  auto devices =
      options.devices_file.empty() ? Result<std::vector<IoOptions>>({options}) : read_devices_file(options.devices_file, options);
  if (!devices) return tl::unexpected(devices.error());
  Hubs hubs;
  for (const IoOptions& device : *devices) {
    auto hub = DeviceHub::open(device, clock);
    if (!hub) return fail("{}{}", name_prefix(device), hub.error().what);
    hubs.push_back(std::move(*hub));
  }
  return hubs;
}

// The exit code when a device has stopped replying for good: its systemd unit does not start io_node again then, only a person does.
constexpr int kDeviceFailed = 3;

// The exit code of this hub: 0 without an error.
int run_hub(DeviceHub& hub, ServiceLiveness& service, std::size_t number, const StopSignal& stop) {
  hub.set_service(&service, number);
  const auto ended = hub.run(stop);
  service.leave(number);
  if (!ended) log_error("{}{}", name_prefix(hub.options()), ended.error().what);
  return ended ? 0 : hub.has_device_failed() ? kDeviceFailed : 1;
}

// Runs each hub in its own thread, so that the fault of one device does not stop the others. Returns the largest of their exit codes.
int run_hubs(const Hubs& hubs, const StopSignal& stop) {
  ServiceLiveness service(hubs.size());
  if (hubs.size() == 1) return run_hub(*hubs.front(), service, 0, stop);
  std::vector<int> codes(hubs.size(), 0);
  std::vector<std::thread> threads;
  for (std::size_t n = 0; n < hubs.size(); ++n) {
    threads.push_back(start_thread([&, n] { codes[n] = run_hub(*hubs[n], service, n, stop); }));
  }
  for (std::thread& thread : threads) thread.join();
  return *std::max_element(codes.begin(), codes.end());
}

int run(const IoOptions& options) {
  const StopSignal stop;
  const SteadyClock clock;
  const auto hubs = open_hubs(options, clock);
  if (!hubs) {
    log_error("{}", hubs.error().what);
    return 1;
  }
  for (const auto& hub : *hubs) print_text("{}\n", hub->describe());
  std::fflush(stdout);
  const int code = run_hubs(*hubs, stop);
  for (const auto& hub : *hubs) hub->forget_device_failure();
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // Makes large blocks, such as a flight record, return to the system when freed: without this call glibc raises the threshold when the
  // first such block is freed.
  ::mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  open_standard_streams();
  outlive_readers();
  check_cpu("io_node");
  check_descriptors("io_node");
  start_log("io_node");
  const auto parsed = parse_io_options(argc, argv);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  return run(std::get<IoOptions>(parsed));
}
