#include "core/force/evaluation/stress_episode.h"

#include <gtest/gtest.h>

#include <set>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

class StressEpisodes : public ::testing::Test {
 protected:
  std::vector<Vec3> positions_of(std::uint64_t number, std::uint64_t seed = 1) {
    StressEpisode episode(mesh_, walk_, 0.1, false, seed, "ball", number);
    motion_ = episode.motion();
    std::vector<Vec3> places;
    episode.draw([](const Vec3&) { return true; }, places);
    return places;
  }

  TriangleMesh mesh_ = make_icosphere(0.05, 2);
  SurfaceWalk walk_{mesh_};
  StressMotion motion_ = StressMotion::count;
};

TEST_F(StressEpisodes, ComeInEveryMotionAndAreShort) {
  std::set<StressMotion> seen;
  for (std::uint64_t number = 0; number < 100; ++number) {
    const std::vector<Vec3> places = positions_of(number);
    EXPECT_GT(places.size(), 1U);
    EXPECT_LE(places.size(), 400U);
    seen.insert(motion_);
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(StressMotion::count));
}

TEST_F(StressEpisodes, DependOnTheirNumberAndSeedAlone) {
  const std::vector<Vec3> first = positions_of(kFirstLongWalk + 7);
  positions_of(3);
  EXPECT_EQ(positions_of(kFirstLongWalk + 7), first);
  EXPECT_NE(positions_of(kFirstLongWalk + 8), first);
  EXPECT_NE(positions_of(kFirstLongWalk + 7, 2), first);
}

TEST_F(StressEpisodes, ALongWalkGoesInAndOutAllOverTheBody) {
  const std::vector<Vec3> places = positions_of(kFirstLongWalk);
  EXPECT_EQ(motion_, StressMotion::walk);
  EXPECT_EQ(places.size(), 20001U);
  std::size_t crossings = 0;
  std::set<int> octants;
  for (std::size_t i = 1; i < places.size(); ++i) {
    crossings += (places[i].norm() < 0.05) != (places[i - 1].norm() < 0.05);
    octants.insert((places[i].x() > 0.0) + 2 * (places[i].y() > 0.0) + 4 * (places[i].z() > 0.0));
    ASSERT_LT((places[i] - places[i - 1]).norm(), 0.02) << "a walk, no jump, at " << i;
  }
  EXPECT_GT(crossings, 100U);
  EXPECT_EQ(octants.size(), 8U);
}

TEST(StressEpisode, EveryMotionHasAName) {
  std::set<std::string_view> names;
  for (int i = 0; i < static_cast<int>(StressMotion::count); ++i) names.insert(name_of(static_cast<StressMotion>(i)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(StressMotion::count));
}

}  // namespace
}  // namespace hapton
