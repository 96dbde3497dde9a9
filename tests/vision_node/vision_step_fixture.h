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
    screen_.picture = {640, 720};
    screen_.screen = compute_screen(framing, screen_.picture);
    screen_.sizes = scale_probe(framing);
  }

  static VisionStepSettings settings() {
    VisionStepSettings made;
    made.max_rate_hz = 100.0;
    made.stereo = "side_by_side";
    return made;
  }

  // One iteration of the loop: draws a picture if one is wanted, which takes 5 ms. Returns whether it drew.
  bool draw_if_wanted(VisionStep& step, std::int64_t now_ns) {
    if (!step.wants_picture(now_ns, screen_)) return false;
    step.compose(now_ns);
    step.end_frame(now_ns, now_ns + 5 * kMs, screen_);
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
    std::vector<T> messages;
    while (const auto message = step.take_message(now_ns)) {
      if (const T* of_type = std::get_if<T>(&*message)) messages.push_back(*of_type);
    }
    return messages;
  }

  VisionStep::Screen screen_;
};

}  // namespace hapton
