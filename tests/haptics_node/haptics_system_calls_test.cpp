// A haptic step, from datagram to datagram, makes no system call.
#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cmath>
#include <memory>

#include "haptic_step/haptics_step.h"
#include "link/codec.h"
#include "link/endpoint.h"
#include "runtime/clock.h"
#include "tests/support/made_meshes.h"
#include "tests/support/system_call_guard.h"

namespace hapton {
namespace {

class HapticsSystemCalls : public testing::TestWithParam<const char*> {};

TEST_P(HapticsSystemCalls, ASlideInAndOutOfContactMakesNone) {
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  std::unique_ptr<HapticsStep> step;
  std::unique_ptr<Codec> codec;
  const auto prepare = [&] {
    const TouchScene scene = {.objects = {{made::shared(made::sphere(0.05, 24)), {}}}};
    step = std::make_unique<HapticsStep>(std::make_unique<TouchStep>(*make_method({.name = GetParam()}, scene)), 1e-5);
    codec = std::make_unique<Codec>();
  };
  const auto work = [&] {
    const SteadyClock clock;
    std::array<std::byte, kMaxDatagramBytes> bytes;
    Datagram datagram;
    for (std::uint64_t n = 1; n <= 5000; ++n) {
      const double angle = 1e-3 * static_cast<double>(n);
      const double radius = 0.05 + 0.004 * std::cos(20.0 * angle);
      const DeviceState state{.sample = n,
                              .sample_time_ns = static_cast<std::int64_t>(n) * 1'000'000,
                              .p_WD = radius * Vec3(std::cos(angle), std::sin(angle), 0.1)};
      std::size_t size = codec->encode({{1, 2, n, clock.now_ns()}, state}, bytes);
      if (codec->decode(std::span(bytes).first(size), datagram) != DecodeStatus::ok) _exit(9);
      const Material other{.stiffness_n_per_m = 500.0 + static_cast<double>(n % 700), .friction_static = 0.3, .friction_dynamic = 0.2};
      if (n % 50 == 0) step->set_materials({&other, 1});
      if (n % 100 == 0) step->turn_scene({.revision = static_cast<std::uint32_t>(n)});
      step->offer(std::get<DeviceState>(datagram.message));
      size = codec->encode({{1, 3, n, clock.now_ns()}, step->reply()}, bytes);
      if (size == 0) _exit(9);
    }
    if (step->counts().contact_steps < 1000) _exit(9);
  };
  EXPECT_EQ(SystemCallGuard::run(prepare, work), "");
}

INSTANTIATE_TEST_SUITE_P(OfEveryLiveMethod, HapticsSystemCalls, testing::Values("proxy", "smooth", "sweep"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace hapton
