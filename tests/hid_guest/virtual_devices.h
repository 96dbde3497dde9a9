#pragma once

#include "core/math/types.h"
#include "docs/hid/hapton_hid_device.h"
#include "tests/hid_guest/uhid_device.h"

namespace hapton::guest {

// The commands that the motors of a virtual device have got since the last clear(), in the order of arrival.
class ReceivedForces {
 public:
  void clear() {
    const std::lock_guard lock(mutex_);
    received_.clear();
  }
  void add(const Vec3& value) {
    const std::lock_guard lock(mutex_);
    received_.push_back(value);
  }
  std::vector<Vec3> all() const {
    const std::lock_guard lock(mutex_);
    return received_;
  }
  Vec3 last() const {
    const std::lock_guard lock(mutex_);
    return received_.empty() ? Vec3::Zero() : received_.back();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Vec3> received_;
};

// WoodenHaptics as its firmware presents it, with 3 or 6 encoders. The upper arm leans 40 degrees, the column does not move.
class VirtualWooden final : public UhidDevice {
 public:
  explicit VirtualWooden(bool has_wrist);
  ~VirtualWooden() override { unplug(); }

  // Sets the angle of the lower arm from the vertical.
  void lean(double degrees) { degrees_ = degrees; }
  // The encoders' counts of the three bodies.
  std::array<std::int16_t, 3> counts() const;
  // The motor currents, mA.
  const ReceivedForces& received() const { return received_; }
  void clear_received() { received_.clear(); }

 protected:
  std::vector<Bytes> make_inputs(std::uint32_t time_us) override;
  void take_output(const Bytes& report, std::uint32_t time_us) override;

 private:
  bool has_wrist_;
  std::atomic<double> degrees_ = 35.0;
  std::uint16_t counter_ = 0;
  ReceivedForces received_;
};

// A Hapton HID device that runs docs/hid/hapton_hid_device.c.
class VirtualHaptonHid final : public UhidDevice {
 public:
  static constexpr int kWatchdogMs = 100;
  static constexpr double kMaxForceN = 6.0;

  VirtualHaptonHid();
  ~VirtualHaptonHid() override { unplug(); }

  void move_to(double z_m) { z_m_ = z_m; }
  // Whether its motors were on when it made its newest state.
  bool is_on() const { return is_on_; }
  // The forces of its motors, N.
  const ReceivedForces& received() const { return received_; }
  void clear_received() { received_.clear(); }

 protected:
  std::vector<Bytes> make_inputs(std::uint32_t time_us) override;
  void take_output(const Bytes& report, std::uint32_t time_us) override;
  Bytes make_feature(std::uint8_t id) override;

 private:
  hapton_hid_device device_;
  std::atomic<double> z_m_ = 0.05;
  std::atomic<bool> is_on_ = false;
  ReceivedForces received_;
};

// A SpaceMouse with a settable cap. Every 16 ms it reports translations, then rotations, then buttons.
class VirtualSpaceMouse final : public UhidDevice {
 public:
  VirtualSpaceMouse();
  ~VirtualSpaceMouse() override { unplug(); }

  void push(int x, int buttons) {
    x_ = x;
    buttons_ = buttons;
  }

 protected:
  std::vector<Bytes> make_inputs(std::uint32_t time_us) override;
  void take_output(const Bytes&, std::uint32_t) override {}

 private:
  std::atomic<int> x_ = 0, buttons_ = 0;
  std::uint32_t next_us_ = 0;
};

// An unsupported device.
class VirtualUnknownDevice final : public UhidDevice {
 public:
  VirtualUnknownDevice();
  ~VirtualUnknownDevice() override { unplug(); }

 protected:
  std::vector<Bytes> make_inputs(std::uint32_t) override { return {}; }
  void take_output(const Bytes&, std::uint32_t) override {}
};

}  // namespace hapton::guest
