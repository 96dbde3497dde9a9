#include "tools/bench/stress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/touch_mesh.h"

namespace hapton {
namespace {

StressPlan small_plan(unsigned threads) {
  StressPlan plan;
  plan.method.name = "reference";
  plan.method.reference_substeps = 1;
  plan.steps = 1200;
  plan.threads = threads;
  plan.variants = {{.scale = 1.0}, {.scale = 1e-3}, {.offset_extents = 10.0}};
  return plan;
}

TEST(Stress, RunsEveryBodyInEveryVariantWhateverTheThreads) {
  const std::vector<StressBody> bodies{make_stress_body("box"), make_stress_body("tetrahedron")};
  std::size_t result_count = 0;
  const auto with_one_thread = run_stress(bodies, small_plan(1), [&](const StressResult&) { ++result_count; });
  const auto with_three_threads = run_stress(bodies, small_plan(3), [](const StressResult&) {});
  ASSERT_TRUE(with_one_thread.has_value() && with_three_threads.has_value());
  EXPECT_EQ(result_count, 6u);
  ASSERT_EQ(with_one_thread->size(), 6u);
  for (std::size_t i = 0; i < with_one_thread->size(); ++i) {
    EXPECT_EQ((*with_one_thread)[i].count.steps, (*with_three_threads)[i].count.steps);
    EXPECT_EQ((*with_one_thread)[i].count.contact_steps, (*with_three_threads)[i].count.contact_steps);
    EXPECT_GE((*with_one_thread)[i].count.steps, 400u);
  }
  EXPECT_EQ(sum_of(*with_one_thread).total_faults(), 0u);
}

TEST(Stress, FindingsComeWithTheCommandThatShowsThemAgain) {
  StressResult result{"box", {.scale = 1e-3}, {}};
  result.count.faults[0] = 1;
  result.count.findings = {{.fault = StressFault::fall_through, .motion = StressMotion::tap_edge, .episode = 77, .step = 5, .size = 0.01}};
  const std::string text = to_text({result}, small_plan(1));
  EXPECT_THAT(text, ::testing::HasSubstr("fall_through in tap-edge at step 5"));
  EXPECT_THAT(text, ::testing::HasSubstr("--body box --seed 1 --scale 0.001"));
  EXPECT_THAT(text, ::testing::HasSubstr("--episode 77"));
  EXPECT_THAT(to_json({result}, small_plan(1)), ::testing::HasSubstr("\"faults\": 1"));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("--no-seal")));
  StressPlan unsealed = small_plan(1);
  unsealed.no_seal = true;
  EXPECT_THAT(to_text({result}, unsealed), ::testing::HasSubstr("--no-seal"));
}

TEST(Stress, TheReportOfAFileWhoseNameIsNotUtf8IsWritten) {
  const StressResult result{"caf\xE9.obj", {}, {}};
  EXPECT_THAT(to_json({result}, small_plan(1)), ::testing::HasSubstr("caf\xEF\xBF\xBD.obj"));
}

TEST(Stress, AFaultThatWasNotCheckedIsNotReportedAsZero) {
  const auto results = run_stress({make_stress_body("tetrahedron")}, small_plan(1), [](const StressResult&) {});
  ASSERT_TRUE(results.has_value());
  EXPECT_THAT(to_text(*results, small_plan(1)),
              ::testing::ContainsRegex("tetrahedron +[0-9]+ +[0-9]+ +[0-9]+ +0 +0 +0 +- +0 +0 +- +0 +0\n"));
  EXPECT_THAT(to_text(*results, small_plan(1)), ::testing::HasSubstr("discontinuity   the force changed by more than"));
  const std::string json = to_json(*results, small_plan(1));
  EXPECT_THAT(json, ::testing::HasSubstr("\"discontinuity\": null"));
  EXPECT_THAT(json, ::testing::HasSubstr("\"fall_through\": 0"));
}

TEST(Stress, LongWalksComeOnTopWhereAVariantGetsTenThousandSteps) {
  StressPlan plan = small_plan(1);
  plan.method.name = "proxy";
  plan.compare_every = 0;
  plan.variants.resize(1);
  plan.steps = 10000;
  const auto steps_of = [&] { return sum_of(*run_stress({make_stress_body("box")}, plan, [](const StressResult&) {})).steps; };
  EXPECT_GE(steps_of(), 30000U);
  plan.steps = 9999;
  EXPECT_LT(steps_of(), 10400U);
}

TEST(Stress, RejectsAnUnknownMethod) {
  StressPlan plan = small_plan(1);
  plan.method.name = "no such method";
  const auto results = run_stress({make_stress_body("box")}, plan, [](const StressResult&) { ADD_FAILURE() << "it ran"; });
  ASSERT_FALSE(results.has_value());
  EXPECT_THAT(results.error().what, ::testing::StartsWith("method 'no such method' is not known; choose one of: "));
  EXPECT_THAT(results.error().what, ::testing::HasSubstr("reference"));
}

// Each of these episodes once had faults, most of them fall-throughs. The notes say what was wrong, or where.
struct OnceFaulty {
  std::string_view body;
  std::uint64_t seed = 1;
  std::uint64_t episode = 0;
  bool has_friction = false;
  bool on_grid = false;
  double offset_extents = 0.0;
  double probe_share = 0.0;
  double scale = 1.0;
};

TEST(Stress, EpisodesThatOnceHadFaultsHaveNone) {
  constexpr std::uint64_t kFirstWalk = 4294967296;  // the number of the first long walk, 2^32
  for (const OnceFaulty& once : std::vector<OnceFaulty>{
           {"turned-room", 1, 13, true},  // a drag went through a wall: its hit was taken for a hit from behind
           {"round-room", 1, 25, true},
           {"turned-room", 5, 236, true},  // in a corner, exactly on its vertex: the point was taken to be free
           {"touching-parts", 1, 16, true},
           {"touching-parts", 1, kFirstWalk, true},
           {"overlapping-parts", 1, 4, true},
           {"overlapping-parts-2", 1, 7, true},
           {"overlapping-parts-2", 1, 15, true},
           {"star", 1, 263, true},
           {"staircase", 1, 395, true},
           {"sealed-ball-fine", 1, 214, true},
           {"overlapping-parts-2", 1, 18, false, true},  // into the slit between sheets that cross at 3e-6 rad
           {"overlapping-parts-2", 1, 32, false, true},
           {"overlapping-parts", 1, 1016, false, true},  // the direction of a motion was mostly rounding
           {"overlapping-parts", 3, 110, false, true},
           {"knife-gutter", 8, 280},                     // the point could not be lifted out of a narrow groove
           {"needles", 1, 75, false, true},              // lifted off a needle to a position behind the face beside it
           {"turned-room", 1, 116, false, true},         // the start was on the wrong side
           {"sealed-box", 1, 21, false, false, 1000.0},  // a device a thousand extents off
           {"sealed-box-fine", 1, 128, false, false, 1000.0},
           {"sealed-star-fine", 1, 437, false, false, 10.0},   // thousands of events at one place
           {"sliver-fan", 6, 352},                             // 3,000 triangles at one vertex
           {"needles", 8, 301, false, false, 0.0, 0.0, 1e-6},  // two nearly parallel planes
           {"overlapping-parts", 8, 364, false, false, 0.0, 0.0, 1e6},
           {"sliver-fan", 8, 399},  // steps that took a few milliseconds: now their work is limited
           {"sliver-fan", 3, 82, false, false, 0.0, 0.001},
           {"needles", 8, 153, false, false, 0.0, 0.0, 1e6},  // one edge held the point twice
           {"probe-star", 9, 194},                            // rolled about the end of an edge, along an edge in line with it
           {"probe-staircase", 9, 372, false, false, 10.0},
           {"overlapping-parts-2", 8, 128},             // the device exactly below a convex edge
           {"sliver-fan", 9, 338, false, false, 10.0},  // a device at 1e300 m: two events a step among 3,000 triangles on its way back
           {"sliver-fan", 8, 31, false, false, 0.0, 0.0, 1e6},
           {"probe-bumpy", 9, 254, false, false, 1e6},                // a device on an edge: to and fro between two neighbours
           {"probe-star", 10, 308, false, false, 0.0, 0.0, 1e6},      // a minimum that vanishes exactly at the sample
           {"needles", 8, 644, false, false, 1e6},                    // a groove of 1e-10 of the extent holds the point
           {"touching-parts", 22, 307, false, false, 0.0, 0.0, 1e6},  // began exactly on an edge, went on within the plane of a face
           {"needles", 1, 83, true},                          // slip along an edge, the device straight below: one cubic spans half a turn
           {"sealed-box", 2, 203, false, false, 1000.0},      // a device a thousand extents off: the work ended before the arrival
           {"overlapping-parts", 21, 39, false, false, 1e6},  // a piece of path went over to the other of two nearly parallel lines
           {"needles", 5, kFirstWalk + 2},                    // in a groove beside a ridge beyond which the surface falls away
       }) {
    StressPlan plan;
    plan.method.name = "proxy";
    plan.seed = once.seed;
    plan.on_grid = once.on_grid;
    plan.probe_share = once.probe_share;
    plan.variants = {{.scale = once.scale, .offset_extents = once.offset_extents}};
    if (once.has_friction) plan.variants[0].friction_static = 0.5;
    if (once.has_friction) plan.variants[0].friction_dynamic = 0.4;
    const auto results = run_episode({make_stress_body(once.body)}, plan, once.episode);
    ASSERT_TRUE(results) << results.error().what;
    EXPECT_EQ(sum_of(*results).total_faults(), 0U) << to_text(*results, plan);
    EXPECT_GT(sum_of(*results).contact_steps, 0U) << once.body;
  }
}

// The point (a small sphere stands for it) touches parts that touch each other: slits as wide as the sphere, vertices where
// sheets cross at very small angles, a blade of three degrees, faces of one plane in a corner, corners where it takes most of a step's work
// to find that no wedge holds the point, wedges out of which a sweep moved it, and a blade where follower and sweeps moved it to and fro
// for ever. Near a crowd of triangles it was put back onto a face in each step. On a scan it stayed for ever when the device jumped far
// away. In one wedge the work ended after a sweep, at a position where only the larger sphere of the sweeps is held.
TEST(Stress, EpisodesThatOnceHadFaultsOnMeshesOfTouchingPartsHaveNone) {
  struct Once {
    std::uint64_t seed, episode;
    double scale = 1.0;
    double offset = 0.0;
  };
  struct OnMesh {
    std::string name;
    std::vector<Once> episodes;
  };
  for (const auto& [name, episodes] :
       {OnMesh{"meshes/barkour_body_dirty.stl",
               {{1, 103},       {1, 138},       {1, 222},           {1, 820},      {1, 1098},      {2, 229},          {4, 8},
                {4, 57},        {5, 141},       {1, 163, 1e-6},     {1, 173, 1e6}, {1, 468, 1e-6}, {1, 486, 1e-3},    {1, 274, 1.0, 1e6},
                {1, 342, 1e-3}, {3, 251, 1e-3}, {3, 251, 1.0, 1e6}, {2, 76, 1e-6}, {2, 76, 1e6},   {2, 76, 1.0, 1e6}, {2, 422, 1.0, 1e6}}},
        OnMesh{"meshes/nist_pump_assembly.glb", {{5, 249}, {5, 249, 1e-3}, {5, 249, 1e-6}, {5, 249, 1.0, 1e6}}},
        OnMesh{"meshes/nist_assembly_insert.obj",
               {{1, 65}, {2, 200}, {3, 94}, {4, 179}, {4, 202}, {5, 80}, {7, 687}, {8, 684}, {5, 440, 1.0, 1e6}, {2, 310, 1.0, 1e6}}},
        OnMesh{"meshes/mountain_51k_open.ply", {{2, 470, 1.0, 1e3}}},
        OnMesh{"meshes/skull_100k.ply", {{1, 375, 1.0, 1e3}, {2, 297, 1.0, 1e3}, {3, 132, 1.0, 1e3}}}}) {
    auto file = load_touch_mesh(std::string(HAPTON_SOURCE_DIR) + "/" + name);
    ASSERT_TRUE(file) << file.error().what;
    const StressBody body = make_stress_body(name, std::move(file->mesh));
    StressPlan plan;
    plan.method.name = "proxy";
    plan.variants.resize(1);
    for (const auto& [seed, episode, scale, offset] : episodes) {
      plan.seed = seed;
      plan.variants[0].scale = scale;
      plan.variants[0].offset_extents = offset;
      const auto results = run_episode({body}, plan, episode);
      ASSERT_TRUE(results) << results.error().what;
      EXPECT_EQ(sum_of(*results).total_faults(), 0U) << to_text(*results, plan);
      EXPECT_GT(sum_of(*results).contact_steps, 0U);
    }
  }
}

TEST(Stress, StepsOutOfWorkAreFinishedAndCounted) {
  StressPlan plan;
  plan.method.name = "proxy";
  plan.seed = 8;
  plan.variants.resize(1);
  const auto results = run_episode({make_stress_body("sliver-fan")}, plan, 399);
  ASSERT_TRUE(results) << results.error().what;
  const StressCount count = sum_of(*results);
  EXPECT_GT(count.carried_steps, 0U);
  EXPECT_LT(count.carried_steps, count.steps);
  EXPECT_THAT(to_json(*results, plan), ::testing::HasSubstr("\"carried_steps\": " + std::to_string(count.carried_steps)));
}

}  // namespace
}  // namespace hapton
