#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "io_node/io_options.h"
#include "link/endpoint.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"

namespace hapton {

class ServiceLiveness;

// One device with its hub: address, device side, network side, watchdog, recorder and reports. Several hubs in one process are independent
// of each other. RT: no, except the threads of device side and network side. Threads: one caller for each hub.
class DeviceHub {
 public:
  // Error, one line: the device cannot be opened, an address is in use, a key or folder is missing. Pre: clock outlives the hub.
  static Result<std::unique_ptr<DeviceHub>> open(const IoOptions& options, const Clock& clock);
  ~DeviceHub();

  Address address() const;
  // "hub on 127.0.0.1:4950, device simulated, 1000 Hz, ...", preceded by the name of the device if it has one.
  std::string describe() const;
  const IoOptions& options() const;

  // Before run(): as IoSession::set_service.
  void set_service(ServiceLiveness* service, std::size_t number) noexcept;

  // Runs until IoSession::run ends, and prints a summary of the recording. Error: as IoSession::run, or of watchdog or recording.
  Result<void> run(const StopSignal& stop);
  // After run(): its device stopped replying for good. run() has latched this for the next start, in case a signal ends this process while
  // other hubs run on: then systemd starts it again.
  bool has_device_failed() const;
  // Removes that latch. To be called when the exit code of the process reports the failure: systemd does not restart it then, so a person
  // makes the next start, and it may have a force.
  void forget_device_failure();

 private:
  struct Parts;
  explicit DeviceHub(std::unique_ptr<Parts> parts);
  Result<void> start_watchdog();
  void restore_latched_fault();
  void keep_device_failure();
  std::unique_ptr<Parts> parts_;
};

}  // namespace hapton
