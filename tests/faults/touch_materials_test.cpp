// Materials that change while the hub computes the force. Times are simulated; only the threads that send and build patches take their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "tests/faults/simulated_system.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// One way, 30 ms: no remote force is used.
void be_far(SimulatedSystem& system) {
  const LinkFaults faults{.delay_ns = 30 * kMs};
  system.set_faults(faults, faults);
}

// The hand is pressed in beside the haptics node, and stays so when the node is far: a hand that begins inside an object has no force.
void press_in_and_be_far(SimulatedSystem& system) {
  system.start_haptics();
  system.run_for_ns(500 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  be_far(system);
  system.run_for_ns(300 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  system.touched.clear();
}

// hapton set: the hub's force goes to the new stiffness by the same fade.
TEST(MaterialsOfPatches, FadeInWhileTheHubComputesTheForce) {
  SimulatedSystem system(7, TouchChoice::patch);
  press_in_and_be_far(system);
  system.run_for_ns(500 * kMs);
  EXPECT_NEAR(system.force_n().z(), 2.0, 0.01);
  const std::size_t first = system.device.written.size();
  system.haptics->set_materials({{.stiffness_n_per_m = 500.0}});
  for (int n = 0; n < 3000 && std::abs(system.force_n().z() - 1.0) > 0.01; ++n) {
    system.run_for_ns(2 * kMs);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_NEAR(system.force_n().z(), 1.0, 0.01);
  double worst_n = 0.0;
  for (std::size_t n = first + 1; n < system.device.written.size(); ++n) {
    worst_n = std::max(worst_n, (system.device.written[n].force_n - system.device.written[n - 1].force_n).norm());
  }
  EXPECT_LT(worst_n, 0.03) << "1 N over 0.1 s";
}

}  // namespace
}  // namespace hapton
