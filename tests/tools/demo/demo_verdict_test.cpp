#include "tools/demo/demo_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tools/demo/demo_shapes.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

// A step in contact with the probe at p_WP and the device `behind_m` behind it (below 0: in front of it).
DemoSample touch(const Vec3& p_WP, double behind_m) {
  return {.time_ns = 0, .p_WD = p_WP - Vec3(0, 0, behind_m), .p_WP = p_WP, .force_n = Vec3(0, 0, 1e3 * behind_m), .contact = true};
}
DemoSample free_step(const Vec3& p_W) { return {.time_ns = 0, .p_WD = p_W, .p_WP = p_W, .force_n = Vec3::Zero(), .contact = false}; }

DemoEvidence evidence_of(std::vector<DemoSample> steps) {
  DemoEvidence evidence;
  evidence.motion.steps = std::move(steps);
  return evidence;
}

TEST(DemoVerdict, RestIsContactThatLastsWithTheDeviceInside) {
  std::vector<DemoSample> steps(100, touch(Vec3::Zero(), 0.002));
  const DemoVerdict rest = evaluate_rest(evidence_of(steps));
  EXPECT_TRUE(rest.has_contact && rest.is_shown) << rest.text;
  EXPECT_THAT(rest.text, HasSubstr("up to 2.0 mm behind the probe"));
  steps.insert(steps.end(), 150, free_step(Vec3::Zero()));
  EXPECT_FALSE(evaluate_rest(evidence_of(steps)).is_shown) << "lost again";
  EXPECT_FALSE(evaluate_rest(evidence_of(std::vector<DemoSample>(100, touch(Vec3::Zero(), 0.0001)))).is_shown) << "brushed";
  const DemoVerdict without_contact = evaluate_rest(evidence_of(std::vector<DemoSample>(100, free_step(Vec3::Zero()))));
  EXPECT_FALSE(without_contact.has_contact || without_contact.is_shown);
  EXPECT_THAT(without_contact.text, HasSubstr("touched nothing"));
}

// A slide over the whole length of the groove, in which the probe moves sideways by `share` times the bends of the groove.
DemoEvidence slide(double share) {
  std::vector<DemoSample> steps;
  for (double x = -0.07; x < 0.07; x += 0.0005) steps.push_back(touch(Vec3(x, share * demo_groove::centre_m(x), -0.006), 0.002));
  return evidence_of(steps);
}

TEST(DemoVerdict, TheGrooveLeadsTheProbeAlongItsBends) {
  EXPECT_TRUE(evaluate_groove(slide(1.0)).is_shown) << evaluate_groove(slide(1.0)).text;
  EXPECT_FALSE(evaluate_groove(slide(0.0)).is_shown) << "straight on, through the walls";
  EXPECT_FALSE(evaluate_groove(slide(-1.0)).is_shown) << "beside the groove";
}

DemoEvidence tap(double step_m, double probe_behind_m) {
  std::vector<DemoSample> steps;
  for (double before_m = 2.5 * step_m; before_m > 0.0; before_m -= step_m)
    steps.push_back(free_step(Vec3(0, 0, demo_wall::kFrontM + before_m)));
  for (int i = 0; i < 20; ++i) steps.push_back(touch(Vec3(0, 0, demo_wall::kFrontM - probe_behind_m), 0.003));
  return evidence_of(steps);
}

TEST(DemoVerdict, TheProbeNeverComesBehindTheWall) {
  EXPECT_TRUE(evaluate_wall(tap(0.0004, 0.0)).is_shown) << evaluate_wall(tap(0.0004, 0.0)).text;
  EXPECT_FALSE(evaluate_wall(tap(0.0004, demo_wall::kThicknessM)).is_shown) << "fallen through";
  DemoEvidence slow = tap(0.00005, 0.0);
  for (DemoSample& step : slow.motion.steps) {
    if (step.contact) step.p_WD.z() = demo_wall::kFrontM - 0.00001;
  }
  EXPECT_FALSE(evaluate_wall(slow).is_shown) << "no step longer than the wall is thick";
}

DemoEvidence with_hop(const char* hop, double p50_us) {
  DemoEvidence evidence = evidence_of(std::vector<DemoSample>(100, touch(Vec3::Zero(), 0.002)));
  evidence.report = {{"hops", {{hop, {{"p50_us", p50_us}, {"p99_us", 2.0 * p50_us}}}}}, {"counters", {{"lost", 3}, {"faults_latched", 0}}}};
  return evidence;
}

TEST(DemoVerdict, TheHeavyMeshRepliesWithinAPeriod) {
  EXPECT_TRUE(evaluate_heavy(with_hop("haptics_compute", 5.0)).is_shown);
  EXPECT_THAT(evaluate_heavy(with_hop("haptics_compute", 5.0)).text, HasSubstr("5.0 us (p50), 10.0 us (p99)"));
  EXPECT_FALSE(evaluate_heavy(with_hop("haptics_compute", 1500.0)).is_shown);
  EXPECT_FALSE(evaluate_heavy(with_hop("round_trip", 5.0)).is_shown) << "not measured";
}

TEST(DemoVerdict, TheNetworkIsSlowAndTheContactStays) {
  EXPECT_TRUE(evaluate_network(with_hop("round_trip", 9000.0), 8.0).is_shown);
  EXPECT_FALSE(evaluate_network(with_hop("round_trip", 100.0), 8.0).is_shown) << "the network was not slow at all";
  DemoEvidence faulty = with_hop("round_trip", 9000.0);
  faulty.report["counters"]["faults_latched"] = 1;
  EXPECT_FALSE(evaluate_network(faulty, 8.0).is_shown);
}

// A force every millisecond, except between last_force_ms and first_force_again_ms. The node is killed at 1000 ms and restarted at 2000 ms.
DemoEvidence death(int last_force_ms, int first_force_again_ms) {
  DemoEvidence evidence = evidence_of(std::vector<DemoSample>(100, touch(Vec3::Zero(), 0.002)));
  for (int ms = 0; ms < 3000; ++ms) {
    evidence.motion.written_forces.push_back({std::int64_t{1'000'000} * ms, ms <= last_force_ms || ms >= first_force_again_ms ? 1.0 : 0.0});
  }
  evidence.killed_ns = 1'000'000'000;
  evidence.restarted_ns = 2'000'000'000;
  return evidence;
}

TEST(DemoVerdict, ADeathReleasesTheMotorsAndTheForceComesBack) {
  EXPECT_TRUE(evaluate_death(death(1018, 2150)).is_shown);
  EXPECT_THAT(evaluate_death(death(1018, 2150)).text, HasSubstr("no force 18 ms after the node is killed, force again 150 ms after"));
  EXPECT_FALSE(evaluate_death(death(1300, 2150)).is_shown) << "held on to the force";
  EXPECT_FALSE(evaluate_death(death(1018, 5000)).is_shown) << "no force after the restart";
  EXPECT_FALSE(evaluate_death(death(-1, 2150)).is_shown) << "no force before it was killed";
}

}  // namespace
}  // namespace hapton
