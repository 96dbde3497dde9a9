#include "core/force/sphere/wedge.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/support/corner_stage.h"

namespace hapton {
namespace {

// The three walls of a corner, and `others`: further meshes of the scene.
struct InCorner : CornerStage {
  static constexpr double kFar = Wedge::kFarthest * kClearance.offset;

  explicit InCorner(std::vector<const TriangleMesh*> others = {}) : CornerStage(2.0 * kFar, std::move(others)) {
    EXPECT_TRUE(near->covers(centre, kFar));
  }
  bool holds() { return Wedge(contacts, *near, centre, work).holds(); }
};

TEST(WedgeOfPlanes, ACornerOfThreeWallsHolds) {
  InCorner in;
  EXPECT_TRUE(in.holds());
  EXPECT_GT(in.work, 0);
}

// The small box lies between the walls, nearer than a way out of the corner may lead (Wedge::kFarthest).
TEST(WedgeOfPlanes, DoesNotHoldWithAnObjectBetweenTheWalls) {
  const TriangleMesh between = made::box(Vec3::Constant(0.004), Vec3::Constant(0.005));
  EXPECT_FALSE(InCorner({&between}).holds());
}

TEST(WedgeOfPlanes, BehindTheWallsNothingCounts) {
  const TriangleMesh behind = made::box(Vec3::Constant(-0.002), Vec3::Constant(-0.001));
  EXPECT_TRUE(InCorner({&behind}).holds());
}

TEST(WedgeOfPlanes, DoesNotHoldWithoutGatheredTriangles) {
  InCorner in;
  in.near->clear();
  EXPECT_FALSE(in.holds());
}

TEST(WedgeOfPlanes, AContactOnAnEdgeIsOverAFaceThere) {
  InCorner in;
  const OffsetContact wall = in.contacts[0];
  for (int k = 0; k < 3; ++k) {
    const OffsetContact edge = OffsetContact::on_edge(wall.triangle, wall.shape, k);
    const int slot = Wedge(in.contacts, *in.near, in.centre, in.work).find_face_there(edge);
    ASSERT_GE(slot, 0);
    const ContactTriangle& face = in.near->shape(slot);
    EXPECT_TRUE(edge.is_shared_with(face));
    EXPECT_EQ(face.separation(in.centre).feature, Feature::face);
    EXPECT_NEAR(face.separation(in.centre).distance, CornerStage::kClearance.offset, 0.25 * CornerStage::kClearance.slop);
  }
}

}  // namespace
}  // namespace hapton
