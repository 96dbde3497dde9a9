#include "tools/latency/latency_verdict.h"

#include <nlohmann/json.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::HasSubstr;

nlohmann::json report(double rate_hz, double round_trip_us, double wake_us) {
  return {
      {"rates_hz", {{"servo_requested", rate_hz}}},
      {"counters", {{"samples", 10'000}, {"late", 2}, {"lost", 1}, {"superseded", 0}, {"missed_cycles", 3}}},
      {"hops", {{"round_trip", {{"n", 10'000}, {"p99_9_us", round_trip_us}}}, {"wake_lateness", {{"n", 10'000}, {"p99_9_us", wake_us}}}}}};
}

TEST(LatencyVerdict, ARateFitsWhenWakeUpAndRoundTripLieWithinItsPeriod) {
  const auto verdict = evaluate_latency(report(1000, 200.0, 40.0));
  ASSERT_TRUE(verdict) << verdict.error().what;
  EXPECT_TRUE(verdict->holds) << verdict->reason;
  ASSERT_EQ(verdict->rates.size(), 3U);
  EXPECT_TRUE(verdict->rates[0].fits);
  EXPECT_TRUE(verdict->rates[1].fits);
  EXPECT_NEAR(verdict->rates[1].margin_us, 10.0, 1e-9);
  EXPECT_FALSE(verdict->rates[2].fits);
  EXPECT_THAT(to_text(*verdict), HasSubstr("verdict at 1 kHz: held"));
  EXPECT_THAT(to_text(*verdict), HasSubstr("not fit for 10 kHz"));
  EXPECT_EQ(to_json(*verdict)["fit_for"][2]["fits"], false);
}

TEST(LatencyVerdict, TheMeasuredRateIsNotHeldWhenItsTimesAreTooLong) {
  const auto verdict = evaluate_latency(report(4000, 230.0, 40.0));
  ASSERT_TRUE(verdict);
  EXPECT_FALSE(verdict->holds);
  EXPECT_THAT(verdict->reason, HasSubstr("270.0 us"));
}

TEST(LatencyVerdict, TheMeasuredRateIsNotHeldWhenTooManyCyclesAreMissed) {
  auto with_missed_cycles = report(1000, 20.0, 4.0);
  with_missed_cycles["counters"]["missed_cycles"] = 50;
  const auto verdict = evaluate_latency(with_missed_cycles);
  ASSERT_TRUE(verdict);
  EXPECT_FALSE(verdict->holds);
  EXPECT_THAT(verdict->reason, HasSubstr("0.53 %"));
  for (const char* cause : {"late", "lost", "superseded"}) {
    auto other = report(1000, 20.0, 4.0);
    other["counters"][cause] = 50;
    EXPECT_FALSE(evaluate_latency(other)->holds) << cause;
  }
}

TEST(LatencyVerdict, AReportWithoutForcesIsAnError) {
  EXPECT_FALSE(evaluate_latency(nlohmann::json::array()));
  auto without_forces = report(1000, 20.0, 4.0);
  without_forces["hops"]["round_trip"]["n"] = 0;
  EXPECT_THAT(evaluate_latency(without_forces).error().what, HasSubstr("no force"));
  auto without_rate = report(1000, 20.0, 4.0);
  without_rate.erase("rates_hz");
  EXPECT_FALSE(evaluate_latency(without_rate));
}

TEST(LatencyVerdict, AValueOfAnotherTypeCountsAsNone) {
  for (const char* section : {"hops", "counters", "rates_hz"}) {
    auto wrong = report(1000, 20.0, 4.0);
    wrong[section] = 7;
    EXPECT_FALSE(evaluate_latency(wrong)) << section;
  }
  auto text = report(1000, 20.0, 4.0);
  text["hops"]["round_trip"]["p99_9_us"] = "long";
  EXPECT_FALSE(evaluate_latency(text));
}

}  // namespace
}  // namespace hapton
