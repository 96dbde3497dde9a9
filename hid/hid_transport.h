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
  std::uint16_t usage = 0;       // of the same collection
  std::string serial;            // UTF-8, like maker and product; empty if the device has none
  std::string maker;
  std::string product;
  HidLayout layout;  // empty if its report descriptor cannot be read
};

// Outcome of a read.
enum class HidIo : std::uint8_t {
  done,
  nothing,  // no report arrived in time
  gone,     // the device was unplugged, or the read failed
};

struct HidRead {
  HidIo outcome = HidIo::nothing;
  std::size_t size = 0;  // bytes of the report
};

// An open HID device. The first byte of a numbered report is its number (id). An unnumbered report has no such byte when it is read, and
// begins with a 0 when it is written. Threads: one for read and note_gone, at the same time another one for write and get_feature; any for
// description. RT: no; read and write are system calls that may wait.
class HidTransport {
 public:
  // Size of a buffer for a report: the largest interrupt packet of USB 2.0 (high speed, 5.7.3). No device known to us has longer reports.
  static constexpr std::size_t kMaxBytes = 1024;

  virtual ~HidTransport() = default;

  virtual const HidDescription& description() const noexcept = 0;

  // Reads the oldest report that was not read yet; waits for one for at most wait_ms. A report longer than `into` is cut off.
  virtual HidRead read(std::span<std::uint8_t> into, int wait_ms) noexcept = 0;

  // To be called after a read has returned `gone`, once the device's driver was notified: it may take long, as it lists the other devices.
  virtual void note_gone() {}

  // Sends an output report. False: not sent. Waits until the bus has accepted it: up to a millisecond with some devices.
  virtual bool write(std::span<const std::uint8_t> report) noexcept = 0;

  // Requests the feature report with the number into[0] (0: unnumbered) and writes it to `into`, after that byte. Returns the number of
  // bytes, including the first. Error: one line.
  virtual Result<std::size_t> get_feature(std::span<std::uint8_t> into) = 0;
};

// Opens a device that was chosen before; called again after the device was unplugged. Error, one line: why it cannot be opened.
using HidOpener = std::function<Result<std::unique_ptr<HidTransport>>()>;

}  // namespace hapton
