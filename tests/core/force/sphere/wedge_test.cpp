#include "core/force/sphere/wedge.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr Clearance kClearanceOfWedges{1e-5, 0x1p-40, 0x1p-46};

// Inside a box, in its lower corner, held by all three walls; and what else there is.
struct InCorner {
  explicit InCorner(std::vector<const TriangleMesh*> others = {}) {
    others.insert(others.begin(), &box);
    geometry = std::make_unique<TouchGeometry>(others);
    materials.resize(others.size());
    near = std::make_unique<GatheredTriangles>(*geometry, materials, kClearanceOfWedges, 1e-4);
    centre = geometry->to_local(Vec3::Zero()) + kClearanceOfWedges.offset * Vec3::Ones();
    const double far = Wedge::kFarthest * kClearanceOfWedges.offset;
    near->widen(2.0 * far);
    EXPECT_TRUE(near->gather(centre, Vec3::Zero(), work));
    EXPECT_TRUE(near->covers(centre, far));
    int slots[12];
    int count = 0;
    near->visit_near(centre, centre, 1.5 * kClearanceOfWedges.offset, [&](int slot) { slots[count++] = slot; });
    for (const Vec3& normal : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
      for (int i = 0; i < count; ++i) {
        const OffsetContact contact = OffsetContact::nearest(near->triangle(slots[i]), near->shape(slots[i]), centre);
        if (contact.part == OffsetContact::Part::face && contact.normal.dot(normal) > 0.9) contacts.add(contact);
      }
    }
    contacts.activate_all();
  }
  bool holds() { return Wedge(contacts, *near, centre, work).holds(); }

  TriangleMesh box = made::box(Vec3::Zero(), Vec3(1.0, 0.9, 0.8));  // the diagonals of its sides miss the centre
  std::unique_ptr<TouchGeometry> geometry;
  std::vector<Material> materials;
  std::unique_ptr<GatheredTriangles> near;
  ContactSet contacts{kClearanceOfWedges};
  Vec3 centre;
  int work = 0;
};

TEST(WedgeOfPlanes, ACornerOfThreeWallsHolds) {
  InCorner in;
  EXPECT_TRUE(in.holds());
  EXPECT_GT(in.work, 0);
}

// Between the walls, nearer than a way out would lead.
TEST(WedgeOfPlanes, NotWithSomethingInBetween) {
  const TriangleMesh between = made::box(Vec3::Constant(0.004), Vec3::Constant(0.005));
  EXPECT_FALSE(InCorner({&between}).holds());
}

TEST(WedgeOfPlanes, BehindTheWallsNothingCounts) {
  const TriangleMesh behind = made::box(Vec3::Constant(-0.002), Vec3::Constant(-0.001));
  EXPECT_TRUE(InCorner({&behind}).holds());
}

TEST(WedgeOfPlanes, WhereItCannotBeSeenItDoesNotHold) {
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
    EXPECT_NEAR(face.separation(in.centre).distance, kClearanceOfWedges.offset, 0.25 * kClearanceOfWedges.slop);
  }
}

}  // namespace
}  // namespace hapton
