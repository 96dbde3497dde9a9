#include "bench/haptons/hapton_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/haptons/extended_pair.h"

namespace hapton {
namespace {

HaptonRun short_run() {
  HaptonRunSettings settings;
  settings.pairs.count = 1024;
  settings.batch = 256;
  settings.seconds = 0.01;
  return measure_haptons(settings);
}

TEST(MeasureHaptons, ChecksEveryPairWithEveryCollider) {
  const HaptonRun run = short_run();
  ASSERT_GE(run.results.size(), 3U);
  EXPECT_TRUE(run.holds());
  for (const HaptonResult& r : run.results) {
    EXPECT_EQ(r.checked, 1024U) << r.name;
    EXPECT_GE(r.batches, 4U) << r.name;
    EXPECT_GE(r.p50_haptons, r.p99_haptons) << r.name;
    EXPECT_GE(r.best_haptons, r.p50_haptons) << r.name;
    EXPECT_GT(r.worst_error, 0.0) << r.name << ": nothing was compared";
  }
}

TEST(MeasureHaptons, ARunWithMissedOrWrongPairsDoesNotHold) {
  HaptonRun run = short_run();
  run.results[0].missed = 1;
  EXPECT_FALSE(run.holds());
  run.results[0].missed = 0;
  run.results[1].mislocated = 1;
  EXPECT_FALSE(run.holds());
  run.results[1].mislocated = 0;
  run.results.back().is_peer = true;
  run.results.back().missed = 1;
  EXPECT_TRUE(run.holds()) << "a peer's accuracy is shown, not required";
}

// A collider is evaluated by the position of its contact. Before it has run, it must report that it has found none (an error below 0).
TEST(PairColliders, HaveFoundNothingBeforeTheyCollide) {
  const auto pairs = make_edge_pairs({.seed = 2, .count = 64});
  for (const auto& collider : make_pair_colliders(pairs)) {
    if (collider->name() != "simd") {  // its lanes are not set before it has run
      EXPECT_LT(collider->location_error(9), 0.0) << collider->name();
    }
    collider->collide(0, 64);
    if (collider->is_peer()) continue;
    for (std::size_t i = 0; i < 64; ++i) {
      EXPECT_GE(collider->location_error(i), 0.0) << collider->name();
      EXPECT_LE(collider->location_error(i), kHaptonAccuracy) << collider->name();
    }
  }
}

// A collider that reports the given errors.
class WrongCollider final : public PairCollider {
 public:
  explicit WrongCollider(std::vector<double> errors) : errors_(std::move(errors)) {}
  std::string name() const override { return "wrong"; }
  std::string what() const override { return "nothing"; }
  bool is_peer() const override { return false; }
  void collide(std::size_t, std::size_t) override {}
  double location_error(std::size_t pair) const override { return errors_[pair]; }

 private:
  std::vector<double> errors_;
};

TEST(MeasureHaptons, ANanErrorCountsAsMislocated) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  HaptonResult result;
  count_errors(WrongCollider({1e-4, kNan, -1.0, 2e-3, 1e-3}), 5, result);
  EXPECT_EQ(result.checked, 5U);
  EXPECT_EQ(result.missed, 1U);
  EXPECT_EQ(result.mislocated, 2U);
  EXPECT_EQ(result.worst_error, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(result.holds());
}

TEST(LocationErrors, OfAnEndThatIsNotFiniteIsInfinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const TrianglePair pair = make_edge_pairs({.seed = 2, .count = 8}).front();
  const ExtendedContact exact = intersect_extended(pair);
  const TriangleContact computed = intersect_triangles(pair);
  ASSERT_EQ(exact.count, 2);
  EXPECT_LT(location_error(computed, exact), kHaptonAccuracy * size_of(pair));
  TriangleContact wrong = computed;
  wrong.end.y() = kNan;
  EXPECT_EQ(location_error(wrong, exact), std::numeric_limits<double>::infinity());
  wrong.begin.x() = kNan;
  EXPECT_EQ(location_error(wrong, exact), std::numeric_limits<double>::infinity());
}

TEST(MeasureHaptons, ReportsAreReadable) {
  const HaptonRun run = short_run();
  const auto json = nlohmann::json::parse(to_json(run));
  EXPECT_EQ(json["schema"], kBenchSchema);
  EXPECT_EQ(json["results"].size(), run.results.size());
  EXPECT_EQ(json["memo_capable_haptons"], 5.0);
  const std::string csv = to_csv(run);
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), run.results.size() + 1);
  EXPECT_NE(to_text(run).find("memo, 1996"), std::string::npos);
}

}  // namespace
}  // namespace hapton
