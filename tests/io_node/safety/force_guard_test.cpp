#include "io_node/safety/force_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace hapton {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr ForceLimits kDevice{8.45, 2112.5};
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

WantedForce force(double z, std::int64_t sample_time_ns) { return {Vec3(0, 0, z), sample_time_ns}; }

// Feeds a constant force at 1 kHz, each answering a sample taken 100 us before.
Vec3 feed(ForceGuard& guard, double z, std::int64_t& now, int steps) {
  Vec3 out = Vec3::Zero();
  for (int n = 0; n < steps; ++n) {
    now += kMs;
    out = guard.step(force(z, now - 100'000), now);
  }
  return out;
}

TEST(ForceGuard, ramps_in_then_passes_a_good_force_unchanged) {
  ForceGuard guard(kDevice);
  std::int64_t now = 0;
  EXPECT_LT(feed(guard, 2.0, now, 1).z(), 0.05);
  EXPECT_NEAR(feed(guard, 2.0, now, 50).z(), 1.0, 0.05);
  EXPECT_EQ(feed(guard, 2.0, now, 100), Vec3(0, 0, 2.0));
  EXPECT_EQ(guard.counters().clamped + guard.counters().slewed + guard.counters().silences, 0U);
}

TEST(ForceGuard, clamps_the_norm_and_keeps_the_direction) {
  ForceGuard guard(kDevice);
  std::int64_t now = 0;
  feed(guard, 1.0, now, 200);
  for (int n = 0; n < 20; ++n) {
    now += kMs;
    guard.step(WantedForce{Vec3(30, 0, 40), now}, now);
  }
  const Vec3 out = guard.step(std::nullopt, now);
  EXPECT_NEAR(out.norm(), 8.45, 1e-9);
  EXPECT_LT((out.normalized() - Vec3(0.6, 0, 0.8)).norm(), 1e-9);
  EXPECT_GT(guard.counters().clamped, 10U);
  EXPECT_GT(guard.counters().slewed, 0U);
}

TEST(ForceGuard, is_zero_after_twenty_milliseconds_of_silence_and_ramps_back) {
  for (const std::int64_t dt : {kMs / 10, kMs, 4 * kMs}) {
    ForceGuard guard(kDevice);
    std::int64_t now = 0;
    ASSERT_EQ(feed(guard, 8.0, now, 300), Vec3(0, 0, 8.0));
    const std::int64_t last = now;
    double before = 8.0;
    while (now < last + 30 * kMs) {
      now += dt;
      const double z = guard.step(std::nullopt, now).z();
      if (now - last <= 15 * kMs) {
        ASSERT_EQ(z, 8.0);
      }
      if (now - last >= 20 * kMs) {
        ASSERT_EQ(z, 0.0) << dt;
      }
      ASSERT_LE(std::abs(z - before), 2112.5e-9 * static_cast<double>(dt) * 1.000001);
      before = z;
    }
    EXPECT_TRUE(guard.silent());
    EXPECT_EQ(guard.counters().silences, 1U);
    EXPECT_LT(feed(guard, 8.0, now, 10).z(), 0.8);
    EXPECT_EQ(feed(guard, 8.0, now, 150).z(), 8.0);
  }
}

TEST(ForceGuard, one_bad_number_is_a_fault_with_a_new_ramp) {
  for (const double bad : {kNan, kInf, -kInf}) {
    ForceGuard guard(kDevice);
    std::int64_t now = 0;
    feed(guard, 4.0, now, 300);
    now += kMs;
    EXPECT_LT(guard.step(WantedForce{Vec3(0, bad, 4.0), now}, now).z(), 4.0);
    now += 5 * kMs;
    EXPECT_EQ(guard.step(std::nullopt, now), Vec3::Zero());
    EXPECT_EQ(guard.counters().not_finite, 1U);
    EXPECT_LT(feed(guard, 4.0, now, 20).z(), 1.0);
  }
}

TEST(ForceGuard, old_repeated_and_future_forces_are_refused_and_do_not_count_as_life) {
  ForceGuard guard(kDevice);
  std::int64_t now = 0;
  feed(guard, 2.0, now, 200);
  const std::int64_t answered = now - 100'000;
  for (int n = 0; n < 25; ++n) {
    now += kMs;
    guard.step(force(7.0, answered), now);
    guard.step(force(7.0, answered - 1), now);
    guard.step(force(7.0, now + 1), now);
    guard.step(force(7.0, std::numeric_limits<std::int64_t>::max()), now);
    guard.step(force(7.0, std::numeric_limits<std::int64_t>::min()), now);
  }
  EXPECT_EQ(guard.step(std::nullopt, now), Vec3::Zero());
  EXPECT_EQ(guard.counters().refused_old, 75U);
  EXPECT_EQ(guard.counters().refused_future, 50U);
  EXPECT_EQ(guard.counters().silences, 1U);
  now += kMs;
  guard.step(force(7.0, now - 21 * kMs), now);
  EXPECT_TRUE(guard.silent());
}

TEST(ForceGuard, limits_can_only_be_tightened) {
  ForceGuard guard(kDevice);
  guard.tighten({100.0, 1e9});
  guard.tighten({kNan, kInf});
  guard.tighten({-1.0, 0.0});
  EXPECT_EQ(guard.limits().max_force_n, 8.45);
  EXPECT_EQ(guard.limits().max_slew_n_per_s, 2112.5);
  guard.tighten({3.0, 50.0});
  EXPECT_EQ(guard.limits().max_force_n, 3.0);
  EXPECT_EQ(guard.limits().max_slew_n_per_s, 50.0);
  guard.tighten({8.0, 2000.0});
  EXPECT_EQ(guard.limits().max_force_n, 3.0);
  std::int64_t now = 0;
  const double out = feed(guard, 8.0, now, 1000).z();
  EXPECT_NEAR(out, 3.0, 1e-9);
  // A tight slew never delays letting go.
  now += 20 * kMs;
  EXPECT_EQ(guard.step(std::nullopt, now), Vec3::Zero());
}

TEST(ForceGuard, tightening_at_full_force_takes_effect_within_the_slew) {
  ForceGuard guard(kDevice);
  std::int64_t now = 0;
  feed(guard, 8.0, now, 300);
  guard.tighten({2.0, 1e9});
  EXPECT_NEAR(feed(guard, 8.0, now, 10).z(), 2.0, 1e-9);
}

TEST(ForceGuard, unusable_limits_give_no_force) {
  for (const ForceLimits limits : {ForceLimits{kNan, 1.0}, ForceLimits{0.0, 1.0}, ForceLimits{1.0, -1.0}, ForceLimits{kInf, 1.0}}) {
    ForceGuard guard(limits);
    std::int64_t now = 0;
    EXPECT_EQ(feed(guard, 8.0, now, 300), Vec3::Zero());
  }
}

// Whatever is said and whenever: finite, within the clamp, within the slew, zero in silence.
TEST(ForceGuard, holds_against_hostile_streams) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::mt19937_64 random(seed);
    const auto share = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const auto pick = [&](std::uint64_t n) { return random() % n; };
    const double nasty[] = {kNan, kInf, -kInf, 1e300, -1e300, std::numeric_limits<double>::max(), 5e-324, 0.0, 8.45, -8.45, 1e9};
    ForceGuard guard(kDevice);
    std::int64_t now = static_cast<std::int64_t>(pick(1'000'000'000'000));
    std::int64_t accepted = -1;
    std::uint64_t accepted_count = 0;
    Vec3 before = Vec3::Zero();
    std::int64_t before_ns = now;
    for (int n = 0; n < 2000; ++n) {
      const bool silent_spell = (n / 100) % 5 == 4;
      switch (pick(8)) {
        case 0:
          break;
        case 1:
          now += 30 * kMs;
          break;
        default:
          now += static_cast<std::int64_t>(share() * 2e6);
          break;
      }
      std::optional<WantedForce> wanted;
      if (!silent_spell && pick(4) != 0) {
        WantedForce w;
        for (int axis = 0; axis < 3; ++axis) w.force_n[axis] = pick(3) == 0 ? nasty[pick(std::size(nasty))] : 40.0 * share() - 20.0;
        if (seed % 2 == 0) w.force_n = Vec3(0, 0, n % 2 == 0 ? 1e300 : -1e300);  // a square wave
        w.sample_time_ns = pick(4) == 0 ? static_cast<std::int64_t>(random()) : now - static_cast<std::int64_t>(share() * 25e6);
        wanted = w;
      }
      const std::int64_t told = pick(50) == 0 ? now - 5 * kMs : now;
      const Vec3 out = guard.step(wanted, told);
      const std::int64_t effective = std::max(told, before_ns);
      if (guard.counters().accepted != accepted_count) {
        accepted_count = guard.counters().accepted;
        accepted = effective;
      }
      ASSERT_TRUE(out.allFinite()) << seed << " " << n;
      ASSERT_LE(out.norm(), 8.45) << seed << " " << n;
      const double passed_s = 1e-9 * static_cast<double>(effective - before_ns);
      ASSERT_LE((out - before).norm(), 2112.5 * passed_s * (1 + 1e-9) + 1e-11) << seed << " " << n;
      if (accepted < 0 || effective - accepted >= ForceGuard::kSilenceLimitNs) {
        ASSERT_LE(out.norm(), 0.0) << seed << " " << n;
      }
      before = out;
      before_ns = effective;
    }
    ASSERT_GT(accepted_count, 0U) << seed;
  }
}

}  // namespace
}  // namespace hapton
