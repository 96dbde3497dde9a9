#include "link/fault_injector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr int kDraws = 200'000;

std::vector<Fate> draw_many(const LinkFaults& faults, std::uint64_t seed = 1, int count = kDraws) {
  FaultInjector injector(seed);
  injector.set(faults);
  std::vector<Fate> fates;
  for (int n = 0; n < count; ++n) fates.push_back(injector.draw(n * kMs));
  return fates;
}

double share_of(const std::vector<Fate>& fates, const std::function<bool(const Fate&)>& holds) {
  return static_cast<double>(std::count_if(fates.begin(), fates.end(), holds)) / static_cast<double>(fates.size());
}

bool is_passed(const Fate& fate) { return fate.kind == Fate::Kind::passed; }

// Five standard deviations of a share in kDraws draws. The seed is fixed, so a test always passes or always fails.
double tolerance(double share) { return 5.0 * std::sqrt(share * (1.0 - share) / kDraws); }

TEST(FaultInjectorTest, WithoutFaultsEverythingPassesAtOnce) {
  for (const Fate& fate : draw_many({}, 3, 1000)) {
    EXPECT_TRUE(is_passed(fate));
    EXPECT_EQ(fate.copies, 1U);
    EXPECT_FALSE(fate.corrupt);
  }
  FaultInjector injector(1);
  EXPECT_EQ(injector.draw(77).due_ns[0], 77);
}

TEST(FaultInjectorTest, OneSeedGivesTheSameFatesAndAnotherOthers) {
  const LinkFaults faults{.jitter_ns = 5 * kMs, .loss = 0.3, .duplicate = 0.2, .corrupt = 0.1};
  const auto as_text = [&](std::uint64_t seed) {
    std::string text;
    for (const Fate& fate : draw_many(faults, seed, 500)) {
      text += fmt::format("{} {} {} {} {};", static_cast<int>(fate.kind), fate.copies, fate.due_ns[0], fate.corrupt, fate.damage);
    }
    return text;
  };
  EXPECT_EQ(as_text(7), as_text(7));
  EXPECT_NE(as_text(7), as_text(8));
}

TEST(FaultInjectorTest, SwitchingOneFaultOnLeavesTheOthersDrawsAsTheyAre) {
  const auto alone = draw_many({.loss = 0.3}, 5, 2000);
  const auto with_more =
      draw_many({.delay_ns = kMs, .jitter_ns = kMs, .loss = 0.3, .reorder = 0.5, .duplicate = 0.5, .corrupt = 0.5}, 5, 2000);
  for (std::size_t n = 0; n < alone.size(); ++n) EXPECT_EQ(alone[n].kind, with_more[n].kind) << n;
}

TEST(FaultInjectorTest, FaultsHaveTheRequestedShares) {
  const auto fates = draw_many({.loss = 0.3, .reorder = 0.05, .duplicate = 0.02, .corrupt = 0.01});
  EXPECT_NEAR(share_of(fates, [](const Fate& f) { return f.kind == Fate::Kind::lost; }), 0.3, tolerance(0.3));
  EXPECT_NEAR(share_of(fates, [](const Fate& f) { return f.held_back; }), 0.05, tolerance(0.05));
  EXPECT_NEAR(share_of(fates, [](const Fate& f) { return f.copies == 2; }), 0.02, tolerance(0.02));
  EXPECT_NEAR(share_of(fates, [](const Fate& f) { return f.corrupt; }), 0.01, tolerance(0.01));
}

TEST(FaultInjectorTest, DelayAndEvenJitterLieWithinTheirRange) {
  const auto fates = draw_many({.delay_ns = 10 * kMs, .jitter_ns = 20 * kMs});
  double sum_ms = 0.0;
  std::int64_t least_ns = 1'000 * kMs;
  std::int64_t most_ns = 0;
  for (std::size_t n = 0; n < fates.size(); ++n) {
    const std::int64_t late_ns = fates[n].due_ns[0] - static_cast<std::int64_t>(n) * kMs;
    sum_ms += 1e-6 * static_cast<double>(late_ns);
    least_ns = std::min(least_ns, late_ns);
    most_ns = std::max(most_ns, late_ns);
  }
  EXPECT_GE(least_ns, 10 * kMs);
  EXPECT_LE(most_ns, 30 * kMs);
  EXPECT_LT(least_ns, 10 * kMs + kMs / 10);
  EXPECT_GT(most_ns, 30 * kMs - kMs / 10);
  EXPECT_NEAR(sum_ms / kDraws, 20.0, 5.0 * 20.0 / std::sqrt(12.0 * kDraws));
}

TEST(FaultInjectorTest, AHeldBackDatagramIsOvertakenButNotItsCopy) {
  const auto fates = draw_many({.reorder = 1.0, .reorder_by_ns = 5 * kMs, .duplicate = 1.0}, 1, 10);
  for (std::size_t n = 0; n < fates.size(); ++n) {
    EXPECT_EQ(fates[n].due_ns[0], static_cast<std::int64_t>(n) * kMs + 5 * kMs);
    EXPECT_EQ(fates[n].due_ns[1], static_cast<std::int64_t>(n) * kMs);
  }
}

TEST(FaultInjectorTest, BurstsHaveTheRequestedShareAndLength) {
  for (const double length : {1.0, 4.0, 20.0}) {
    const auto fates = draw_many({.burst_share = 0.1, .burst_length = length});
    const auto is_bad = [](const Fate& fate) { return fate.kind == Fate::Kind::lost_in_burst; };
    int bursts = 0;
    for (std::size_t n = 1; n < fates.size(); ++n) bursts += is_bad(fates[n]) && !is_bad(fates[n - 1]) ? 1 : 0;
    const double share = share_of(fates, is_bad);
    // Draws within a burst depend on each other, so fewer of them count.
    EXPECT_NEAR(share, 0.1, tolerance(0.1) * std::sqrt(2.0 * length)) << length;
    EXPECT_NEAR(share * kDraws / bursts, length, 0.1 * length) << length;
  }
}

// The mean length of a run of independent losses is 1 / (1 - loss).
TEST(FaultInjectorTest, LossByChanceHasBurstsOfItsOwnLengthOnly) {
  const auto fates = draw_many({.loss = 0.3});
  int bursts = 0;
  for (std::size_t n = 1; n < fates.size(); ++n) bursts += !is_passed(fates[n]) && is_passed(fates[n - 1]) ? 1 : 0;
  EXPECT_NEAR(0.3 * kDraws / bursts, 1.0 / 0.7, 0.03);
}

TEST(FaultInjectorTest, ABurstMayLoseOnlySome) {
  const auto fates = draw_many({.loss = 0.01, .burst_share = 0.4, .burst_length = 5.0, .burst_loss = 0.5});
  // Bursts lose 0.4 * 0.5 of all, and chance 0.01 of the 0.6 outside them.
  EXPECT_NEAR(share_of(fates, [](const Fate& f) { return f.kind == Fate::Kind::lost_in_burst; }), 0.2, 0.01);
  EXPECT_NEAR(share_of(fates, [](const Fate& f) { return f.kind == Fate::Kind::lost; }), 0.006, 0.001);
}

TEST(FaultInjectorTest, NothingPassesAPartition) {
  FaultInjector injector(1);
  injector.set({.partition = true});
  for (int n = 0; n < 100; ++n) EXPECT_EQ(injector.draw(n).kind, Fate::Kind::partitioned);
  injector.set({});
  EXPECT_TRUE(is_passed(injector.draw(0)));
}

TEST(FaultInjectorTest, DamageChangesExactlyOneByte) {
  for (const std::uint64_t damage : {0ULL, 1ULL, 255ULL, 256ULL, ~0ULL, 0x123456789ABCDEFULL}) {
    std::vector<std::byte> bytes(57, std::byte{0x55});
    damage_bytes(bytes, damage);
    EXPECT_EQ(std::count(bytes.begin(), bytes.end(), std::byte{0x55}), 56) << damage;
  }
  damage_bytes({}, 5);
}

TEST(FaultInjectorTest, FaultsOutOfRangeAreNamed) {
  const auto complaint = [](const LinkFaults& faults) {
    const auto checked = check_faults(faults);
    return checked ? std::string() : checked.error().what;
  };
  EXPECT_EQ(complaint({}), "");
  EXPECT_EQ(complaint({.delay_ns = 60'000 * kMs, .jitter_ns = 20 * kMs, .loss = 1.0, .burst_share = 0.5}), "");
  EXPECT_THAT(complaint({.loss = 1.1}), testing::HasSubstr("loss is 1.1"));
  EXPECT_THAT(complaint({.duplicate = -0.1}), testing::HasSubstr("duplicate"));
  EXPECT_THAT(complaint({.corrupt = std::nan("")}), testing::HasSubstr("corrupt"));
  EXPECT_THAT(complaint({.delay_ns = -1}), testing::HasSubstr("delay"));
  EXPECT_THAT(complaint({.burst_length = 0.5}), testing::HasSubstr("burst length"));
  EXPECT_THAT(complaint({.burst_share = 0.9, .burst_length = 2.0}), testing::HasSubstr("burst share 0.9"));
}

}  // namespace
}  // namespace hapton
