#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "io_node/io_options.h"
#include "link/endpoint.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"

namespace hapton {

// One device and all that serves it: hub port, servo, guard, recorder, reports. Several in one process know nothing of each other.
// RT: no; its servo's thread is. Threads: one, another for each hub.
class DeviceHub {
 public:
  // Error: the device is not to be had, the address is taken, a key or folder is missing; one line. Pre: clock outlives it.
  static Result<std::unique_ptr<DeviceHub>> open(const IoOptions& options, const Clock& clock);
  ~DeviceHub();

  Address address() const;
  // "hub on 127.0.0.1:4950, device simulated, 1000 Hz, ...", with its name in front where it has one.
  std::string describe() const;
  const IoOptions& options() const;

  // From the start to the end (see IoSession::run), and says how it went. Error: as there, or a recording that could not be written.
  Result<void> run(const StopSignal& stop);

 private:
  struct Parts;
  explicit DeviceHub(std::unique_ptr<Parts> parts);
  Result<void> start_watchdog();
  void restore_latched_fault();
  std::unique_ptr<Parts> parts_;
};

}  // namespace hapton
