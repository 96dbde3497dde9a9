#include "tools/soak/soak_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// An hour without an event, with an observation every 30 s and some jitter in each figure, as in a real run.
SoakRun make_hour_run() {
  SoakRun run{.seconds = 3600.0, .rate_hz = 1000.0, .processes = {"haptics_node", "io_node"}, .samples = {}, .end_reason = {}};
  for (int i = 1; i <= 120; ++i) {
    const int jitter = (i * 37) % 11 - 5;
    run.samples.push_back({.seconds = 30.0 * i,
                           .samples_hz = 1000.0 + 0.1 * jitter,
                           .forces_hz = 999.9 + 0.1 * jitter,
                           .late = i / 40,
                           .missed_cycles = i / 30,
                           .round_trip_p50_us = 40.0,
                           .round_trip_p99_us = 90.0 + jitter,
                           .round_trip_max_us = i == 70 ? 5000.0 : 300.0,
                           .drift_ms = 4.0 * jitter,
                           .processes = {{20'000 + 8 * jitter, 9, 3}, {8'000 + 4 * jitter, 12, 2}}});
  }
  return run;
}

const SoakFinding& find_finding(const SoakVerdict& verdict, const std::string& what, const std::string& process = "") {
  for (const SoakFinding& one : verdict.findings) {
    if (one.what == what && one.process == process) return one;
  }
  throw std::out_of_range(what);
}

std::size_t count_not_flat(const SoakVerdict& verdict) {
  return static_cast<std::size_t>(
      std::count_if(verdict.findings.begin(), verdict.findings.end(), [](const SoakFinding& one) { return !one.is_flat; }));
}

TEST(SoakVerdict, AnHourWithoutAnEventIsFlat) {
  const SoakRun run = make_hour_run();
  const SoakVerdict verdict = evaluate_soak(run);
  EXPECT_TRUE(verdict.is_flat) << to_text(run, verdict);
  EXPECT_THAT(to_text(run, verdict), HasSubstr("soak: flat over 3600 s"));
  EXPECT_THAT(to_text(run, verdict), HasSubstr("slowest round trip 5000 us"));
  const auto json = to_json(run, verdict);
  EXPECT_EQ(json["schema"], "hapton.soak/1");
  EXPECT_EQ(json["flat"], true);
  EXPECT_EQ(json["findings"].size(), verdict.findings.size());
  EXPECT_EQ(json["processes"][1]["name"], "io_node");
  EXPECT_EQ(json["round_trip_max_us"], 5000.0);
}

// The text names the observed figures in the order of the findings, and those that are constant together at the end.
TEST(SoakVerdict, AFlatRunSaysWhatItLookedAt) {
  SoakRun run = make_hour_run();
  const std::string text = to_text(run, evaluate_soak(run));
  EXPECT_THAT(text, HasSubstr("soak: flat over 3600 s: 3 late, 4 missed cycles, slowest round trip 5000 us, forces lost: 0, "));
  EXPECT_THAT(text, HasSubstr(" samples and "));
  EXPECT_THAT(text, HasSubstr(", ticks drifted "));
  EXPECT_THAT(text, HasSubstr(", haptics_node memory "));
  EXPECT_THAT(text, HasSubstr(", io_node memory "));
  EXPECT_THAT(text, testing::EndsWith("; descriptors and threads constant"));
  EXPECT_THAT(text, Not(HasSubstr("ran for the requested time")));
  EXPECT_THAT(text, Not(HasSubstr("descriptors +")));
  EXPECT_THAT(text, Not(HasSubstr("threads +")));
  run.samples.back().lost = 2;
  for (SoakSample& sample : run.samples) sample.forces_hz = 900.0;
  EXPECT_THAT(to_text(run, evaluate_soak(run)),
              testing::StartsWith("soak: not flat: forces lost: 2; 1000.0 samples and 900.0 forces a second of 1000"));
}

TEST(SoakVerdict, EachCounterOfTheReportHasTheNumberOfItsName) {
  SoakRun run = make_hour_run();
  run.samples.back().lost = 1;
  run.samples.back().late = 2;
  run.samples.back().superseded = 3;
  run.samples.back().missed_cycles = 4;
  const nlohmann::ordered_json counters = {{"lost", 1}, {"late", 2}, {"superseded", 3}, {"missed_cycles", 4}};
  EXPECT_EQ(to_json(run, evaluate_soak(run))["counters"], counters);
}

TEST(SoakVerdict, MemoryThatCreepsIsNotFlatAndIsReportedByProgram) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.processes[0].resident_kib += static_cast<std::int64_t>(sample.seconds);
  const SoakVerdict verdict = evaluate_soak(run);
  EXPECT_FALSE(verdict.is_flat);
  EXPECT_EQ(count_not_flat(verdict), 1U);
  EXPECT_NEAR(find_finding(verdict, "memory", "haptics_node").value, 3240.0, 60.0);
  EXPECT_THAT(to_text(run, verdict), HasSubstr("not flat: haptics_node memory +"));
  EXPECT_THAT(to_text(run, verdict), Not(HasSubstr("io_node")));
}

TEST(SoakVerdict, MemoryThatJumpsOnceIsNotFlat) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.processes[1].resident_kib += sample.seconds > 2200.0 ? 4096 : 0;
  EXPECT_FALSE(find_finding(evaluate_soak(run), "memory", "io_node").is_flat);
}

TEST(SoakVerdict, MemoryThatGrowsInTheFirstTenthOnlyOrShrinksIsFlat) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.processes[0].resident_kib -= sample.seconds < 300.0 ? 10'000 : 0;
  for (SoakSample& sample : run.samples) sample.processes[1].resident_kib -= static_cast<std::int64_t>(sample.seconds);
  EXPECT_TRUE(evaluate_soak(run).is_flat);
}

TEST(SoakVerdict, OneOutlierDoesNotFailTheRun) {
  SoakRun run = make_hour_run();
  run.samples.back().processes[0] = {90'000, 40, 12};
  run.samples[60].processes[1].descriptors = 13;
  run.samples[61].samples_hz = 400.0;
  EXPECT_TRUE(evaluate_soak(run).is_flat) << to_text(run, evaluate_soak(run));
}

TEST(SoakVerdict, ADescriptorMoreIsNotFlat) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.processes[1].descriptors += sample.seconds > 2200.0 ? 1 : 0;
  const SoakVerdict verdict = evaluate_soak(run);
  EXPECT_EQ(count_not_flat(verdict), 1U);
  EXPECT_THAT(to_text(run, verdict), HasSubstr("io_node descriptors +1.0 of 12"));
}

TEST(SoakVerdict, AThreadLessIsNotFlat) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.processes[0].threads -= sample.seconds > 1800.0 ? 1 : 0;
  EXPECT_FALSE(find_finding(evaluate_soak(run), "threads", "haptics_node").is_flat);
}

TEST(SoakVerdict, ALostForceIsNotFlatEvenInTheWarmUp) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.lost = 1;
  const SoakVerdict verdict = evaluate_soak(run);
  EXPECT_EQ(count_not_flat(verdict), 1U);
  EXPECT_THAT(to_text(run, verdict), HasSubstr("forces lost: 1"));
}

TEST(SoakVerdict, ARateThatIsNotHeldIsNotFlat) {
  SoakRun run = make_hour_run();
  for (SoakSample& sample : run.samples) sample.forces_hz = 960.0;
  EXPECT_EQ(find_finding(evaluate_soak(run), "rate").value, 960.0);
  EXPECT_FALSE(evaluate_soak(run).is_flat);
}

TEST(SoakVerdict, TicksThatDriftFromTheClockAreNotFlatWhicheverWay) {
  for (const double ppm : {-300.0, 300.0}) {
    SoakRun run = make_hour_run();
    for (SoakSample& sample : run.samples) sample.drift_ms += 1e-3 * ppm * sample.seconds;
    const SoakVerdict verdict = evaluate_soak(run);
    EXPECT_EQ(count_not_flat(verdict), 1U) << ppm;
    EXPECT_NEAR(find_finding(verdict, "drift").value, 3.24 * ppm, 20.0);
  }
}

TEST(SoakVerdict, ARunCutShortIsNotFlatAndSaysWhy) {
  SoakRun run = make_hour_run();
  run.end_reason = "io_node ended with 139: Segmentation fault";
  run.samples.resize(40);
  EXPECT_FALSE(evaluate_soak(run).is_flat);
  EXPECT_THAT(to_text(run, evaluate_soak(run)), HasSubstr("not flat: io_node ended with 139: Segmentation fault, after 1200 s"));
}

TEST(SoakVerdict, TooFewObservationsAreNoProof) {
  SoakRun run = make_hour_run();
  run.samples.clear();
  EXPECT_FALSE(evaluate_soak(run).is_flat);
  EXPECT_EQ(to_json(run, evaluate_soak(run))["flat"], false);
  EXPECT_THAT(to_text(run, evaluate_soak(run)), HasSubstr("too few observations"));
}

TEST(FindRise, SamplesOfALongSeriesGiveTheSameRise) {
  std::vector<double> times(20'000);
  std::iota(times.begin(), times.end(), 0.0);
  std::vector<double> values;
  for (const double t : times) values.push_back(0.5 * t + (static_cast<int>(t) % 7));
  EXPECT_NEAR(find_rise(times, values), 10'000.0, 50.0);
}

}  // namespace
}  // namespace hapton
