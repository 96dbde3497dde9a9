#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "devices/device.h"
#include "link/messages.h"
#include "runtime/log.h"
#include "tests/devices/device_runner.h"

namespace hapton {

// One device of a vendor, run as the device loop runs it.
struct ServedDevice : testing::Test {
  static void SetUpTestSuite() { start_log("test"); }
  // Destroys the device before the stand-in for the hardware, which belongs to the test's own fixture.
  void TearDown() override { device.reset(); }

  // Makes the device with that id; empty: the first device.
  virtual Result<std::unique_ptr<Device>> make(const std::string& id) = 0;
  Result<std::unique_ptr<Device>> make() { return make(""); }
  // Tries again if the machine stood still for longer than the time for which a device is waited for.
  void open() {
    auto made = make("");
    for (int attempt = 1; attempt < 4 && !made; ++attempt) made = make("");
    ASSERT_TRUE(made) << made.error().what;
    device = std::move(*made);
    EXPECT_LT(device->name().size(), LoopFacts().device.size()) << "the haptics node would not know it";
  }
  template <class Condition>
  bool serve_until(Condition&& holds, const Wrench& wrench = {}) {
    return runner.serve_until(*device, holds, wrench);
  }
  // Interrupts the force, for example by unplugging the device, until the test has seen the force return in small steps. A test that stands
  // still meanwhile sees only the end of the ramp: then this tries again. The argument of interrupt is the number of the attempt, from 1.
  bool ramps_up(const std::function<void(std::uint64_t)>& interrupt, const std::function<bool()>& saw_small_steps) {
    for (std::uint64_t attempt = 1; attempt <= 10 && !HasFatalFailure(); ++attempt) {
      interrupt(attempt);
      if (saw_small_steps()) return true;
    }
    return false;
  }
  bool serve_until_ready() {
    return serve_until([&] { return device->status() == DeviceStatus::ready; });
  }

  std::unique_ptr<Device> device;
  DeviceRunner runner;
};

}  // namespace hapton
