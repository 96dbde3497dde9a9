#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/base/result.h"
#include "hid/hid_layout.h"

namespace hapton {

// One interface of a HID device that is plugged in.
struct HidDescription {
  std::string path;  // "/dev/hidraw0"
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;
  std::uint16_t usage_page = 0;  // of its first top-level collection
  std::uint16_t usage = 0;       // of the same
  std::string serial;            // texts are UTF-8, empty if the device has none
  std::string maker;
  std::string product;
  HidLayout layout;  // empty if its report descriptor cannot be read
};

// Outcome of a read.
enum class HidIo : std::uint8_t {
  done,
  nothing,  // no report arrived in time
  gone,     // unplugged
};

struct HidRead {
  HidIo outcome = HidIo::nothing;
  std::size_t size = 0;  // bytes of the report
};

// An open HID device. The first byte of a numbered report is its number. An unnumbered report has no such byte when it is read, and a 0
// when it is written.
// Threads: one that reads and, at the same time, one for all other calls. RT: no; read and write are system calls that may wait.
class HidTransport {
 public:
  // Buffer for a report: the largest interrupt packet of USB 2.0 (high speed, 5.7.3). No device that we know has longer reports.
  static constexpr std::size_t kMaxBytes = 1024;

  virtual ~HidTransport() = default;

  virtual const HidDescription& description() const noexcept = 0;

  // Reads the oldest report that was not read yet; waits for one, at most wait_ms. A longer report than `into` is cut off.
  virtual HidRead read(std::span<std::uint8_t> into, int wait_ms) noexcept = 0;

  // Call it after a read has found the device gone, once whoever drives it knows: what is noted about what is left may take a while.
  virtual void note_gone() {}

  // Sends an output report. False: not sent. Waits until the bus has taken it: up to a millisecond with some devices.
  virtual bool write(std::span<const std::uint8_t> report) noexcept = 0;

  // Requests the feature report with the number into[0] (0: unnumbered). The report follows that byte; returns the number of bytes, the
  // first included. Error: one line.
  virtual Result<std::size_t> get_feature(std::span<std::uint8_t> into) = 0;
};

// Opens a device that was chosen before; called again after the device was unplugged. Error, one line: why there is none.
using HidOpener = std::function<Result<std::unique_ptr<HidTransport>>()>;

}  // namespace hapton
