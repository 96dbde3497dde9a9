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

// One interface of one plugged-in device.
struct HidDescription {
  std::string path;  // "/dev/hidraw0"
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;
  std::uint16_t usage_page = 0;  // of its first top-level collection
  std::uint16_t usage = 0;
  std::string serial;  // texts are UTF-8, empty where the device has none
  std::string maker;
  std::string product;
  HidLayout layout;  // empty where its report descriptor cannot be read
};

enum class HidIo : std::uint8_t {
  done,
  nothing,  // no report came in time
  gone,     // unplugged
};

struct HidRead {
  HidIo outcome = HidIo::nothing;
  std::size_t size = 0;
};

// An open HID device. A report that has a number carries it in its first byte; one without has no such byte when it is read, and a 0 when
// it is written.
// Threads: one that reads and one that does the rest, at the same time. RT: read and write are system calls that may wait.
class HidTransport {
 public:
  // More than any interrupt report of USB up to high speed that we know of.
  static constexpr std::size_t kMostBytes = 1024;

  virtual ~HidTransport() = default;

  virtual const HidDescription& description() const noexcept = 0;

  // The oldest report that has not been read yet; waits for one, wait_ms at most. What is longer than `into` is cut off.
  virtual HidRead read(std::span<std::uint8_t> into, int wait_ms) noexcept = 0;

  // False: not sent. Waits until the bus has taken it, which with some devices is a millisecond.
  virtual bool write(std::span<const std::uint8_t> report) noexcept = 0;

  // Requests feature report into[0], a byte that stays there; returns the number of bytes received, that one included. Error: one line.
  virtual Result<std::size_t> get_feature(std::span<std::uint8_t> into) = 0;
};

// Opens the device that was chosen when it was made; called again after that has gone. Error: one line, why there is none.
using HidOpener = std::function<Result<std::unique_ptr<HidTransport>>()>;

}  // namespace hapton
