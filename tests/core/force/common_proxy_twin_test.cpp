#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/force/common_proxy.h"
#include "tests/core/force/moving_plates.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

double drawn_between(std::mt19937_64& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

Vec3 normal_vector(std::mt19937_64& random, double size) {
  std::normal_distribution<double> normal(0.0, size);
  const double x = normal(random);
  const double y = normal(random);
  return {x, y, normal(random)};
}

// Boxes and spheres that overlap: once all with one motion, and once each with a motion of its own, which is the same.
struct TwinScenes {
  TwinScenes(std::mt19937_64& random, int count, double scale, bool moves, const Material& material) {
    const Quat turn(Eigen::AngleAxisd(moves ? 1.0 : 0.0, normal_vector(random, 1.0).normalized()));
    const Vec3 shift = (moves ? scale : 0.0) * normal_vector(random, 0.02);
    const auto motion_for = [&](double rest_s) {
      return std::make_shared<const KeyframeMotion>(
          Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {10.0, shift, turn}, {10.0 + rest_s, shift, turn}},
          false);
    };
    for (int i = 0; i < count; ++i) {
      const Vec3 half(drawn_between(random, 0.006, 0.015), drawn_between(random, 0.006, 0.015), drawn_between(random, 0.006, 0.015));
      TriangleMesh mesh = drawn_between(random, 0.0, 1.0) < 0.6 ? made::box(-half, half) : made::sphere(half.x(), 10);
      const Mat3 turned = Eigen::AngleAxisd(drawn_between(random, 0.0, 3.0), normal_vector(random, 1.0).normalized()).toRotationMatrix();
      const Vec3 centre = normal_vector(random, 0.007);
      for (Vec3& vertex : mesh.vertices) {
        vertex = scale * (turned * vertex + centre);
        one.part_of.grow(vertex);
      }
      one.objects.push_back({.mesh = made::shared(std::move(mesh)), .material = material, .motion = motion_for(1.0)});
    }
    several = one;
    for (int i = 0; i < count; ++i) several.objects[static_cast<std::size_t>(i)].motion = motion_for(1.0 + i);
  }

  TouchScene one;
  TouchScene several;
};

struct TwinRuns {
  int contact_steps = 0;
  int separations = 0;    // steps in which the two forces begin to differ, although neither jumps
  double excess_n = 0.0;  // largest force less stiffness times the distance from proxy to device
};

// The hand moves on a smooth path in the frame of the objects, in and out of them. The forces of the twins count as equal if they differ by
// no more than the lift of CommonProxy explains.
TwinRuns follow_twins(std::uint64_t seed, double scale, double speed_m_per_s, double rate_hz, bool moves, const Material& material) {
  std::mt19937_64 random(seed);
  const TwinScenes scenes(random, 2 + static_cast<int>(seed % 5), scale, moves, material);
  const auto one = make_method_for(scenes.one);
  const auto several = make_method_for(scenes.several);
  TwinRuns runs;
  if (one == nullptr || several == nullptr) return runs;
  std::vector<std::pair<Vec3, Vec3>> waves;
  for (int k = 0; k < 4; ++k) waves.emplace_back(normal_vector(random, 0.013), normal_vector(random, 0.013));
  const double lift_n = 64.0 * CommonProxy::kLift * scenes.one.part_of.diagonal() * material.stiffness_n_per_m;
  Vec3 last_p_SD = Vec3::Zero();
  MethodOutput last_a;
  MethodOutput last_b;
  bool was_different = false;
  for (int i = 0; i < static_cast<int>(10.0 * rate_hz); ++i) {
    const double time_s = i / rate_hz;
    Vec3 hand = std::max(0.0, 1.0 - time_s) * Vec3(0, 0, 0.08);
    for (std::size_t k = 0; k < waves.size(); ++k) {
      const double angle = std::numbers::pi * speed_m_per_s * static_cast<double>(k + 1) * time_s;
      hand += std::min(1.0, time_s) * (std::cos(angle) * waves[k].first + std::sin(angle) * waves[k].second);
    }
    const Vec3 p_SD = scenes.one.objects[0].motion->pose_at(time_s) * Vec3(scale * hand);
    if (i == 0) one->reset(p_SD);
    if (i == 0) several->reset(p_SD);
    const MethodInput input{.p_SD = p_SD, .dt_s = 1.0 / rate_hz, .time_s = time_s};
    const MethodOutput a = one->step(input);
    const MethodOutput b = several->step(input);
    runs.contact_steps += a.contact ? 1 : 0;
    const double moved_n = material.stiffness_n_per_m * (p_SD - last_p_SD).norm();
    const bool is_different = (a.force_n - b.force_n).norm() > 1e-6 * a.force_n.norm() + lift_n;
    const double smooth_n = 3.0 * moved_n;
    const bool jumps = (a.force_n - last_a.force_n).norm() > smooth_n || (b.force_n - last_b.force_n).norm() > smooth_n;
    runs.separations += is_different && !was_different && !jumps ? 1 : 0;
    was_different = is_different;
    last_p_SD = p_SD;
    last_a = a;
    last_b = b;
    runs.excess_n = std::max(runs.excess_n, b.force_n.norm() - material.stiffness_n_per_m * (b.p_SP - p_SD).norm());
    EXPECT_TRUE(b.force_n.allFinite());
  }
  return runs;
}

// A hand that presses no deeper than 4 mm, as a person's does, in scenes that stand still. Its depth is measured from the proxy of the
// first twin. Returns the number of steps in which the two forces differ by more than 50 mN.
int count_differing_steps(std::uint64_t seed, double rate_hz) {
  std::mt19937_64 random(seed);
  const TwinScenes scenes(random, 2 + static_cast<int>(seed % 4), 2.0, false, {.stiffness_n_per_m = 800.0});
  const auto one = make_method_for(scenes.one);
  const auto several = make_method_for(scenes.several);
  Vec3 hand(0.1, 0.08, 0.09);
  one->reset(hand);
  several->reset(hand);
  Vec3 goal = Vec3::Zero();
  int differing_steps = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 40 == 0) goal = normal_vector(random, 0.02);
    const Vec3 way = goal - hand;
    hand += std::min(1.0, 0.3 / rate_hz / std::max(way.norm(), 1e-9)) * way;
    const MethodOutput a = one->step({.p_SD = hand, .dt_s = 1.0 / rate_hz});
    const MethodOutput b = several->step({.p_SD = hand, .dt_s = 1.0 / rate_hz});
    differing_steps += (a.force_n - b.force_n).norm() > 0.05 ? 1 : 0;
    const Vec3 depth = hand - a.p_SP;
    if (depth.norm() > 0.004) hand = a.p_SP + 0.004 / depth.norm() * depth;
  }
  return differing_steps;
}

// In the sample in which the hand slides off an edge of a part, the first round has other planes than those that hold the proxy in the end.
TEST(CommonProxyTwin, SlidesOffEdgesAsOneMethodDoes) {
  int differing_seeds = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) differing_seeds += count_differing_steps(seed, 500.0) > 0 ? 1 : 0;
  EXPECT_LE(differing_seeds, 6) << "seeds of 40";
}

// Each object is a part of its own: at scales from 100 um to 100 m, in a frame that moves, and at other speeds and rates. Where the proxy
// jumps, the twins may come to rest in different local minima: then their forces differ until the next jump.
TEST(CommonProxyTwin, IsOneMethodForAllObjects) {
  struct Case {
    double scale = 1.0;
    double speed = 0.3;
    double rate_hz = 1000.0;
    bool moves = false;
  };
  for (const Case& c :
       {Case{}, Case{.scale = 1e-3}, Case{.scale = 1e3}, Case{.moves = true}, Case{.speed = 0.1}, Case{.rate_hz = 4000.0}}) {
    TwinRuns all;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      if (HasFailure()) return;
      SCOPED_TRACE(testing::Message() << "seed " << seed << " scale " << c.scale << " speed " << c.speed << " moves " << c.moves);
      const Material material{.stiffness_n_per_m = 1000.0 / c.scale};
      const TwinRuns runs = follow_twins(seed, c.scale, c.speed, c.rate_hz, c.moves, material);
      EXPECT_LT(runs.excess_n, 1e-3);
      all.contact_steps += runs.contact_steps;
      all.separations += runs.separations;
    }
    EXPECT_GT(all.contact_steps, 1000);
    EXPECT_LE(all.separations, all.contact_steps / 1000) << "scale " << c.scale << " speed " << c.speed << " rate " << c.rate_hz;
  }
}

}  // namespace
}  // namespace hapton
