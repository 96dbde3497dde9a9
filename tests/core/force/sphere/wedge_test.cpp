#include "core/force/sphere/wedge.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/support/corner_stage.h"

namespace hapton {
namespace {

// The three walls of a corner, and `others`: further meshes of the scene.
struct SphereInCorner : CornerStage {
  static constexpr double kFar = Wedge::kFarthest * kClearance.offset;

  explicit SphereInCorner(std::vector<const TriangleMesh*> others = {}) : CornerStage(2.0 * kFar, std::move(others)) {
    EXPECT_TRUE(near->covers(centre, kFar));
  }
  bool holds() { return Wedge(contacts, *near, centre, work).holds(); }
};

TEST(WedgeOfPlanes, ACornerOfThreeWallsHolds) {
  SphereInCorner sphere;
  EXPECT_TRUE(sphere.holds());
  EXPECT_GT(sphere.work, 0);
}

// The small box lies between the walls, nearer than a way out of the corner may lead (Wedge::kFarthest).
TEST(WedgeOfPlanes, DoesNotHoldWithAnObjectBetweenTheWalls) {
  const TriangleMesh between = made::box(Vec3::Constant(0.004), Vec3::Constant(0.005));
  EXPECT_FALSE(SphereInCorner({&between}).holds());
}

TEST(WedgeOfPlanes, BehindTheWallsNothingCounts) {
  const TriangleMesh behind = made::box(Vec3::Constant(-0.002), Vec3::Constant(-0.001));
  EXPECT_TRUE(SphereInCorner({&behind}).holds());
}

TEST(WedgeOfPlanes, DoesNotHoldWithoutGatheredTriangles) {
  SphereInCorner sphere;
  sphere.near->clear();
  EXPECT_FALSE(sphere.holds());
}

TEST(WedgeOfPlanes, AContactOnAnEdgeIsOverAFaceThere) {
  SphereInCorner sphere;
  const OffsetContact wall = sphere.contacts[0];
  for (int k = 0; k < 3; ++k) {
    const OffsetContact edge = OffsetContact::on_edge(wall.triangle, wall.shape, k);
    const int slot = Wedge(sphere.contacts, *sphere.near, sphere.centre, sphere.work).find_face_there(edge);
    ASSERT_GE(slot, 0);
    const ContactTriangle& face = sphere.near->shape(slot);
    EXPECT_TRUE(edge.is_shared_with(face));
    EXPECT_EQ(face.separation(sphere.centre).feature, Feature::face);
    EXPECT_NEAR(face.separation(sphere.centre).distance, CornerStage::kClearance.offset, 0.25 * CornerStage::kClearance.slop);
  }
}

}  // namespace
}  // namespace hapton
