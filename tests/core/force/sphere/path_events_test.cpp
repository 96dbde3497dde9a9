#include "core/force/sphere/path_events.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfEvents = 2415;
constexpr Clearance kClearanceOfEvents{0.02, 0x1p-40, 0x1p-46};

// A centre in contact with one face of a bumpy sphere, from outside.
class PathEventsOf : public testing::Test {
 protected:
  PathEventsOf() { RecordProperty("seed", std::to_string(kSeedOfEvents)); }
  double unit() { return unit_(random_); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(geometry->triangle_count()); }
  double least_distance(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < count(); ++t) least = std::min(least, geometry->separation(t, p).distance);
    return least;
  }
  PathEvents events() { return {contacts, *near, *space, work}; }
  std::unique_ptr<TouchGeometry> make_geometry() const { return std::make_unique<TouchGeometry>(std::vector<const TriangleMesh*>{&mesh}); }
  // Returns false if another triangle is nearer.
  bool place_on(std::uint32_t triangle) {
    const ObjectGeometry::Corners corners = geometry->corners(triangle);
    const ContactTriangle shape(corners.a, corners.b, corners.c);
    const double u = 0.2 + 0.2 * unit();
    const double v = 0.2 + 0.2 * unit();
    centre = corners.a + u * (corners.b - corners.a) + v * (corners.c - corners.a) + kClearanceOfEvents.offset * shape.normal();
    const OffsetContact face = OffsetContact::on_face(triangle, shape, shape.normal());
    contacts.hold_by({&face, 1});
    return near->is_clear_here(centre, kClearanceOfEvents.slop, work);
  }
  // A path in the plane of the face.
  CentrePath path_over_face(double length) {
    const Vec3 normal = contacts[0].normal;
    const Vec3 any(unit(), unit(), unit());
    return CentrePath::straight(centre, centre + length * (any - normal.dot(any) * normal).normalized());
  }

  TriangleMesh mesh = made::sphere(0.4, 24, 0.05);
  std::unique_ptr<TouchGeometry> geometry = make_geometry();
  std::vector<Material> materials{Material{}};
  std::unique_ptr<GatheredTriangles> near = std::make_unique<GatheredTriangles>(*geometry, materials, kClearanceOfEvents, 1e-4);
  std::unique_ptr<PathEvents::Space> space = std::make_unique<PathEvents::Space>();
  ContactSet contacts{kClearanceOfEvents};
  Vec3 centre = Vec3::Zero();
  int work = 0;
  std::mt19937_64 random_{kSeedOfEvents};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

TEST_F(PathEventsOf, TheFirstEventIsThatOfFineSampling) {
  constexpr int kSamples = 50;
  int exits = 0;
  int hits = 0;
  for (std::uint32_t triangle = 0; triangle < count(); triangle += 5) {
    if (!place_on(triangle)) continue;
    const OffsetContact before = contacts[0];
    const CentrePath path = path_over_face(0.3);
    PathEvents::Event event;
    ASSERT_TRUE(events().find(path, event));
    ASSERT_LT(event.time, 1.0) << "no face is that long";
    const OffsetContact& face = contacts[0];
    if (event.contact >= 0) {
      ++exits;
      EXPECT_EQ(event.contact, 0);
      EXPECT_EQ(face.triangle, before.triangle) << "no two faces lie in one plane";
      const double beyond = event.exit.direction.dot(path.at(event.time) - event.exit.origin);
      EXPECT_NEAR(beyond, PathEvents::kOnBoundary, 0x1p-48);
    } else {
      ++hits;
      ASSERT_GE(event.slot, 0);
      EXPECT_NE(near->triangle(event.slot), face.triangle);
      EXPECT_NEAR(near->shape(event.slot).separation(path.at(event.time)).distance, kClearanceOfEvents.offset, kClearanceOfEvents.slop);
    }
    for (int k = 0; k < kSamples; ++k) {
      const Vec3 p = path.at(event.time * k / kSamples);
      ASSERT_GE(least_distance(p), kClearanceOfEvents.offset - kClearanceOfEvents.slop) << triangle << " at " << k;
      for (int edge = 0; edge < 3; ++edge) ASSERT_GT(before.shape.inside(edge, p), -1e-12) << triangle;
    }
    // A little later the centre is too near, or no longer over the face.
    const Vec3 later = path.at(event.time + 1e-7);
    EXPECT_TRUE(event.contact >= 0 ? before.shape.inside(event.exit.index, later) < 0.0
                                   : least_distance(later) < kClearanceOfEvents.offset);
  }
  EXPECT_GT(exits, 50);
  EXPECT_GT(hits, 20);
}

TEST_F(PathEventsOf, FacesInOnePlaneAreCrossedWithoutAnEvent) {
  mesh = made::sheet(0.4, 0.0, 12);
  geometry = make_geometry();
  near = std::make_unique<GatheredTriangles>(*geometry, materials, kClearanceOfEvents, 1e-4);
  for (std::uint32_t triangle = 0; triangle < count(); triangle += 5) {
    ASSERT_TRUE(place_on(triangle));
    const OffsetContact before = contacts[0];
    const CentrePath path = path_over_face(0.2);
    PathEvents::Event event;
    ASSERT_TRUE(events().find(path, event));
    const Vec3 there = path.at(event.time) - kClearanceOfEvents.offset * contacts[0].normal;
    EXPECT_LT(contacts[0].shape.separation(there).distance, 1e-12) << "on the face that the path ends over";
    EXPECT_EQ(event.slot, -1);
    if (event.contact >= 0) {
      const TouchGeometry::Adjacent across = geometry->adjacent(contacts[0].triangle, event.exit.index);
      EXPECT_TRUE(!across.exists || across.id == contacts[0].triangle) << "at the boundary of the sheet";
    }
    events().undo_level_faces();
    EXPECT_EQ(contacts[0].triangle, before.triangle);
  }
}

TEST_F(PathEventsOf, TheDistanceToTheBoundaryIsThatOfTheFirstExit) {
  for (std::uint32_t triangle = 0; triangle < count(); triangle += 7) {
    if (!place_on(triangle)) continue;
    const CentrePath path = path_over_face(1.0);
    double first_exit = 1.0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 out = contacts[0].shape.edge(k).cross(contacts[0].normal).normalized();
      const double pace = out.dot(path.end() - centre);
      if (pace > 0.0) first_exit = std::min(first_exit, (out.dot(contacts[0].shape.corner(k) - centre) + PathEvents::kOnBoundary) / pace);
    }
    const double distance = events().distance_to_boundary(centre, path.end() - centre, 1.0);
    EXPECT_NEAR(distance, 1.25 * first_exit + 0x1p-10 * kClearanceOfEvents.offset, 1e-13);
    EXPECT_EQ(events().distance_to_boundary(centre, path.end() - centre, 0.5 * first_exit), std::numeric_limits<double>::infinity());
  }
}

TEST_F(PathEventsOf, APathIsClearOverAFaceOnlyWithinItAndFarFromOthers) {
  int clear = 0;
  int unclear = 0;
  for (std::uint32_t triangle = 0; triangle < count(); triangle += 2) {
    if (!place_on(triangle)) continue;
    const CentrePath path = path_over_face(0.02 + 0.02 * unit());
    const Vec3 along = (path.end() - centre).normalized();
    if (!events().is_clear_over_face(centre, path.end(), along, along)) {
      ++unclear;
      continue;
    }
    ++clear;
    for (int k = 0; k <= 20; ++k) {
      const Vec3 p = path.at(0.05 * k);
      EXPECT_GE(least_distance(p), kClearanceOfEvents.offset - kClearanceOfEvents.slop);
      for (int edge = 0; edge < 3; ++edge) EXPECT_GE(contacts[0].shape.inside(edge, p), -1e-12);
    }
  }
  EXPECT_GT(clear, 20);
  EXPECT_GT(unclear, 20);
}

}  // namespace
}  // namespace hapton
