#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tests/support/time_units.h"
#include "vision_node/vision_step.h"

namespace hapton {

class VisionStepTest : public testing::Test {
 protected:
  VisionStepTest() {
    const Framing framing = frame_sphere(Vec3::Zero(), 0.12, 0.063);
    where_.picture = {640, 720};
    where_.screen = compute_screen(framing, where_.picture);
    where_.sizes = scale_probe(framing);
  }

  static VisionStepSettings settings() {
    VisionStepSettings made;
    made.max_rate_hz = 100.0;
    made.stereo = "side_by_side";
    return made;
  }

  // One iteration of the loop: draws if a picture is wanted, which takes 5 ms. True: it has drawn.
  bool turn(VisionStep& step, std::int64_t now_ns) {
    if (!step.wants_picture(now_ns, where_)) return false;
    step.compose(now_ns);
    step.end_frame(now_ns, now_ns + 5 * kMs, where_);
    return true;
  }

  static ProbeState state_at(double x_m, std::uint64_t sample, std::uint32_t revision = 1) {
    ProbeState state;
    state.sample = sample;
    state.sample_time_ns = static_cast<std::int64_t>(sample) * kMs;
    state.p_WD = {x_m, 0.0, 0.0};
    state.servo_rate_hz = 1000.0F;
    state.view_revision = revision;
    return state;
  }

  template <class T>
  static std::vector<T> take_all(VisionStep& step, std::int64_t now_ns) {
    std::vector<T> found;
    while (const auto message = step.take_message(now_ns)) {
      if (const T* wanted = std::get_if<T>(&*message)) found.push_back(*wanted);
    }
    return found;
  }

  VisionStep::Screen where_;
};

}  // namespace hapton
