#include "link/clock_offset.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <random>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

// An exchange with a clock that is ahead by offset_ns. The two directions take out_ns and back_ns; the other side replies after 5 us.
ClockOffset::Exchange exchange(std::int64_t t1_ns, std::int64_t offset_ns, std::int64_t out_ns, std::int64_t back_ns) {
  const std::int64_t t2_ns = t1_ns + out_ns + offset_ns;
  return {t1_ns, t2_ns, t2_ns + 5 * kUs, t1_ns + out_ns + 5 * kUs + back_ns};
}

TEST(ClockOffsetTest, EqualPathTimesGiveItExactly) {
  ClockOffset offset;
  EXPECT_FALSE(offset.is_known());
  offset.add(exchange(1'000'000, 777'777'777, 30 * kUs, 30 * kUs));
  ASSERT_TRUE(offset.is_known());
  EXPECT_EQ(offset.offset_ns(), 777'777'777);
  EXPECT_NEAR(static_cast<double>(offset.error_bound_ns(1'065'000)), 30e3, 2.0);
}

// The exchange is faster than the clocks can resolve: both ends of the interval of possible offsets are the offset.
TEST(ClockOffsetTest, AnExchangeThatTakesNoTimeGivesItExactly) {
  ClockOffset offset;
  offset.add(exchange(0, 5, 0, 0));
  ASSERT_TRUE(offset.is_known());
  EXPECT_EQ(offset.offset_ns(), 5);
  EXPECT_LE(offset.error_bound_ns(0), 6);
}

TEST(ClockOffsetTest, TheTruthIsWithinTheBoundWhateverTheNetworkDoes) {
  std::mt19937_64 random(5);
  std::exponential_distribution<double> queueing(1.0 / 200e3);
  ClockOffset offset;
  std::int64_t worst_bound_ns = 0;
  for (int n = 0; n < 20'000; ++n) {
    // The clocks drift apart by 500 ppm, and one direction takes longer: the worst case for an estimate that takes them as equal.
    const std::int64_t t1_ns = n * 1'000'000LL;
    const auto true_ns = static_cast<std::int64_t>(-3e9 + 500e-6 * static_cast<double>(t1_ns));
    const auto out_ns = 20 * kUs + static_cast<std::int64_t>(queueing(random));
    const auto back_ns = 60 * kUs + static_cast<std::int64_t>(queueing(random));
    const auto made = exchange(t1_ns, true_ns, out_ns, back_ns);
    offset.add(made);
    const std::int64_t bound_ns = offset.error_bound_ns(made.t4_ns);
    ASSERT_LE(std::abs(offset.offset_ns() - true_ns), bound_ns) << n;
    if (n > 1000) worst_bound_ns = std::max(worst_bound_ns, bound_ns);
  }
  // Exchanges with little queueing are frequent enough to keep the bound below the mean queueing time.
  EXPECT_LT(worst_bound_ns, 150 * kUs);
}

TEST(ClockOffsetTest, TimesThatCannotBeAreLeftOut) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  ClockOffset offset;
  offset.add({10, 0, 0, 5});         // the reply arrived before the request left
  offset.add({0, 100, 50, 10});      // the other side replied before the request arrived
  offset.add({0, 100, 5000, 10});    // the other side held it for longer than the whole exchange took
  offset.add({-5, kMax, kMax, 10});  // overflows
  offset.add({0, kMin, kMax, 10});   // overflows
  offset.add({kMin, 0, 0, kMax});    // overflows
  EXPECT_FALSE(offset.is_known());
  offset.add(exchange(0, 5, 10, 10));
  EXPECT_TRUE(offset.is_known());
  offset.forget();
  EXPECT_FALSE(offset.is_known());
}

}  // namespace
}  // namespace hapton
