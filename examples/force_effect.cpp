// Shows: forces in free space. Effects that Hapton has (a magnet, a viscous ball) act within the step; one of your own is added to its
// result. Run:   force_effect
#include <cstdio>
#include <memory>

#include "core/force/touch_step.h"

using namespace hapton;

// A channel along x through the origin: it lets the hand slide along and pulls it back from the sides, never with more than 2 N.
struct ChannelEffect {
  double stiffness_n_per_m = 200.0;
  Vec3 force(const EffectSample& hand) const noexcept {
    const Vec3 from_axis(0.0, hand.p_SD.y(), hand.p_SD.z());
    return bounded_force(-stiffness_n_per_m * from_axis, 2.0);
  }
};

int main() {
  auto floor = std::make_shared<TriangleMesh>();
  floor->vertices = {{-0.2, -0.05, -0.2}, {0.2, -0.05, -0.2}, {0.2, -0.05, 0.2}, {-0.2, -0.05, 0.2}};
  floor->triangles = {{0, 2, 1}, {0, 3, 2}};
  TouchScene scene{{{floor, {}}}};
  scene.effects.push_back(SnapEffect{.position = {0.05, 0.0, 0.0}});
  scene.effects.push_back(ViscousEffect{.damping_ns_per_m = 3.0, .volume = EffectVolume::ball(Vec3::Zero(), 0.02)});
  auto method = make_method({}, scene);
  if (!method) return std::fprintf(stderr, "%s\n", method.error().what.c_str()), 1;
  TouchStep touch(std::move(*method), scene);
  const ChannelEffect channel;

  std::printf("x_m,y_m,fx_n,fy_n\n");
  double max_force_n = 0.0;
  Vec3 hand(-0.1, 0.004, 0.0);
  touch.reset({.p_WD = hand});
  for (int k = 0; k < 2000; ++k) {
    hand.x() += 1e-4;  // 0.1 m/s at 1 kHz
    const Vec3 force_n = touch.step({.p_WD = hand}).force_n + channel.force({.p_SD = hand, .time_s = 1e-3 * k});
    max_force_n = std::max(max_force_n, force_n.norm());
    if (k % 100 == 0) std::printf("%.3f,%.3f,%.3f,%.3f\n", hand.x(), hand.y(), force_n.x(), force_n.y());
  }
  return max_force_n > 0.5 && max_force_n < 10.0 ? 0 : 1;
}
