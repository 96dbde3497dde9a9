#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace hapton::guest {

using Bytes = std::vector<std::uint8_t>;

// A HID device that this program pretends to have plugged into the kernel it runs on, by /dev/uhid: the kernel's HID stack and hidraw
// treat it as they treat a real one. It reports a thousand times a second from a thread of its own.
class UhidDevice {
 public:
  struct Identity {
    std::string name;
    std::string serial;
    std::uint16_t vid = 0;
    std::uint16_t pid = 0;
    Bytes descriptor;
  };

  explicit UhidDevice(Identity identity) : identity_(std::move(identity)) {}
  virtual ~UhidDevice() = default;
  UhidDevice(const UhidDevice&) = delete;
  UhidDevice& operator=(const UhidDevice&) = delete;

  void plug_in();
  void unplug();
  // Reports since construction, over all times at which it was plugged in.
  std::uint64_t inputs() const { return inputs_; }
  std::uint64_t outputs() const { return outputs_; }

 protected:
  // Called by the device's thread. time_us wraps.
  virtual std::vector<Bytes> make_inputs(std::uint32_t time_us) = 0;
  virtual void take_output(const Bytes& report, std::uint32_t time_us) = 0;
  virtual Bytes make_feature(std::uint8_t) { return {}; }

 private:
  void run();
  void receive(int wait_ms);

  Identity identity_;
  int descriptor_ = -1;
  std::atomic<bool> ends_ = false;
  std::atomic<std::uint64_t> inputs_ = 0, outputs_ = 0;
  std::thread thread_;
};

}  // namespace hapton::guest
