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
    std::vector<Vec3> positions;
    episode.draw([](const Vec3&) { return true; }, positions);
    return positions;
  }

  TriangleMesh mesh_ = make_icosphere(0.05, 2);
  SurfaceWalk walk_{mesh_};
  StressMotion motion_ = StressMotion::count;
};

TEST_F(StressEpisodes, ComeInEveryMotionAndAreShort) {
  std::set<StressMotion> motions;
  for (std::uint64_t number = 0; number < 100; ++number) {
    const std::vector<Vec3> positions = positions_of(number);
    EXPECT_GT(positions.size(), 1U);
    EXPECT_LE(positions.size(), 400U);
    motions.insert(motion_);
  }
  EXPECT_EQ(motions.size(), static_cast<std::size_t>(StressMotion::count));
}

TEST_F(StressEpisodes, DependOnTheirNumberAndSeedAlone) {
  const std::vector<Vec3> first = positions_of(kFirstLongWalk + 7);
  positions_of(3);
  EXPECT_EQ(positions_of(kFirstLongWalk + 7), first);
  EXPECT_NE(positions_of(kFirstLongWalk + 8), first);
  EXPECT_NE(positions_of(kFirstLongWalk + 7, 2), first);
}

TEST_F(StressEpisodes, ALongWalkGoesInAndOutAllOverTheBody) {
  const std::vector<Vec3> positions = positions_of(kFirstLongWalk);
  EXPECT_EQ(motion_, StressMotion::walk);
  EXPECT_EQ(positions.size(), 20001U);
  std::size_t crossings = 0;
  std::set<int> octants;
  for (std::size_t i = 1; i < positions.size(); ++i) {
    crossings += (positions[i].norm() < 0.05) != (positions[i - 1].norm() < 0.05);
    octants.insert((positions[i].x() > 0.0) + 2 * (positions[i].y() > 0.0) + 4 * (positions[i].z() > 0.0));
    ASSERT_LT((positions[i] - positions[i - 1]).norm(), 0.02) << "a walk, no jump, at " << i;
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
