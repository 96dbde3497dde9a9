#include "io_node/sample_ledger.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

namespace hapton {
namespace {

using Verdict = SampleLedger::Verdict;
constexpr std::int64_t kMs = 1'000'000;

ForceCommand to(std::uint64_t sample, std::uint32_t skipped = 0) {
  ForceCommand command;
  command.echo_sample = sample;
  command.echo_sample_time_ns = static_cast<std::int64_t>(sample) * kMs;
  command.skipped_samples = skipped;
  return command;
}

struct Ledger : testing::Test {
  std::unique_ptr<SampleLedger> ledger = std::make_unique<SampleLedger>();
  void take(std::uint64_t from, std::uint64_t last, bool is_expected = true) {
    for (std::uint64_t s = from; s <= last; ++s) ledger->take(s, static_cast<std::int64_t>(s) * kMs, is_expected);
  }
};

TEST_F(Ledger, tells_in_time_late_reordered_duplicate_and_unknown_apart) {
  EXPECT_EQ(ledger->answer(to(0)), Verdict::unknown);
  take(1, 1);
  EXPECT_FALSE(ledger->is_newest_answered());
  EXPECT_EQ(ledger->answer(to(1)), Verdict::in_time);
  EXPECT_TRUE(ledger->is_newest_answered());
  EXPECT_EQ(ledger->answer(to(1)), Verdict::duplicate);
  take(2, 5);
  EXPECT_EQ(ledger->answer(to(4)), Verdict::late);
  EXPECT_EQ(ledger->answer(to(3)), Verdict::reordered);
  EXPECT_EQ(ledger->answer(to(6)), Verdict::unknown);
  ForceCommand forged = to(5);
  forged.echo_sample_time_ns += 1;
  EXPECT_EQ(ledger->answer(forged), Verdict::unknown);
  EXPECT_EQ(ledger->answer(to(~std::uint64_t{0})), Verdict::unknown);
}

TEST_F(Ledger, overtaken_and_never_answered_is_lost_after_the_patience) {
  take(1, 10);
  ledger->answer(to(5));
  ledger->settle(SampleLedger::kPatienceNs);
  EXPECT_EQ(ledger->counts().lost, 0U);
  ledger->settle(SampleLedger::kPatienceNs + 100 * kMs);
  EXPECT_EQ(ledger->counts().lost, 4U);  // 6 to 10 still wait: nothing newer has been answered
  EXPECT_EQ(ledger->answer(to(3)), Verdict::reordered);
  EXPECT_EQ(ledger->counts().lost, 3U);
}

TEST_F(Ledger, skipped_is_superseded_not_lost) {
  take(1, 10);
  ledger->answer(to(2));
  ledger->answer(to(9, 4));
  EXPECT_EQ(ledger->counts().superseded, 4U);  // 5 to 8
  ledger->close(true);
  EXPECT_EQ(ledger->counts().lost, 4U);  // 1, 3, 4 and 10
}

TEST_F(Ledger, a_lie_about_skipping_excuses_no_more_than_there_is) {
  take(1, 10);
  ledger->answer(to(9, ~std::uint32_t{0}));
  EXPECT_EQ(ledger->counts().superseded, 8U);
  ledger->answer(to(10, ~std::uint32_t{0}));
  EXPECT_EQ(ledger->counts().superseded, 8U);
}

TEST_F(Ledger, nobody_there_is_excused) {
  take(1, 10, false);
  take(11, 20);
  ledger->answer(to(12));
  ledger->excuse_waiting();
  EXPECT_EQ(ledger->counts().lost, 1U);  // 11: overtaken
  EXPECT_EQ(ledger->counts().excused, 18U);
  EXPECT_EQ(ledger->answer(to(5)), Verdict::reordered);
  EXPECT_EQ(ledger->counts().excused, 17U);
}

// Whatever comes, every sample is in one place only.
TEST_F(Ledger, counts_always_add_up) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    ledger = std::make_unique<SampleLedger>();
    std::uint64_t newest = 0;
    for (int n = 0; n < 60'000; ++n) {
      const auto what = random() % 100;
      if (what < 60)
        take(newest + 1, newest + 1, random() % 10 != 0), ++newest;
      else if (what < 97)
        ledger->answer(to(newest - std::min(newest, random() % 30), static_cast<std::uint32_t>(random() % 4)));
      else if (what < 98)
        ledger->answer(to(random() % (newest + 10), static_cast<std::uint32_t>(random())));
      else if (what < 99)
        ledger->settle(static_cast<std::int64_t>(newest) * kMs);
      else if (random() % 50 == 0)
        ledger->excuse_waiting();
    }
    ledger->close(seed % 2 == 0);
    const auto& c = ledger->counts();
    ASSERT_EQ(c.taken, c.in_time + c.late + c.reordered + c.superseded + c.lost + c.excused) << seed;
    ASSERT_GT(c.lost, 0U);
  }
}

TEST_F(Ledger, forgets_what_is_older_than_its_capacity) {
  take(1, 3 * SampleLedger::kCapacity);
  EXPECT_EQ(ledger->answer(to(1)), Verdict::unknown);
  EXPECT_EQ(ledger->answer(to(2 * SampleLedger::kCapacity)), Verdict::unknown);
  EXPECT_EQ(ledger->answer(to(2 * SampleLedger::kCapacity + 1)), Verdict::late);
  EXPECT_EQ(ledger->counts().excused, 2 * SampleLedger::kCapacity);
}

}  // namespace
}  // namespace hapton
