// A sphere that is placed in a slit narrower than itself, in a tube of many triangles, or exactly on a surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "core/force/proxy/proxy_method.h"
#include "core/geometry/contact_triangle.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSlitProbeRadius = 0.004;
constexpr double kSlitGap = 0.005;  // of the slit, x = 0 to kSlitGap
constexpr double kEnd = -0.03;      // of its closed end, z
constexpr double kMouth = 0.0;      // z
const Vec3 kSlitStart(0.0022, 0.003, -0.01);

// Two blocks, and one that closes the slit between them at the bottom; turned by the seed.
class NarrowSlit : public ::testing::TestWithParam<unsigned> {
 protected:
  NarrowSlit() : random_(GetParam()) {
    TriangleMesh mesh =
        joined(made::box({-0.03, -0.05, -0.05}, {0.0, 0.05, kMouth}), made::box({kSlitGap, -0.05, -0.05}, {0.03, 0.05, kMouth}));
    mesh = joined(mesh, made::box({-0.03, -0.05, kEnd - 0.01}, {0.03, 0.05, kEnd}));
    turn_ = Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized().toRotationMatrix();
    for (Vec3& vertex : mesh.vertices) vertex = turn_ * vertex;
    mesh_ = made::shared(mesh);
    method_ = make_method({.name = "proxy", .probe_radius_m = kSlitProbeRadius}, {.objects = {{mesh_, {}}}}).value();
    RecordProperty("seed", std::to_string(GetParam()));
  }
  void reset(const Vec3& device) { method_->reset(turn_ * device); }
  // The position of the probe for this device point, both in coordinates in which the slit is not turned.
  Vec3 step(const Vec3& device) {
    output_ = method_->step({.p_SD = turn_ * device});
    for (int i = 0; method_->carried_from() && i < 64; ++i) output_ = method_->step({.p_SD = turn_ * device});
    return turn_.transpose() * output_.p_SP;
  }
  double distance_by_brute_force(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < mesh_->triangles.size(); ++i) {
      const ContactTriangle shape(mesh_->corner(i, 0), mesh_->corner(i, 1), mesh_->corner(i, 2));
      least = std::min(least, shape.separation(turn_ * p).distance);
    }
    return least;
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  std::mt19937_64 random_;
  Mat3 turn_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::unique_ptr<ForceMethod> method_;
  MethodOutput output_;
};

TEST_P(NarrowSlit, TheSphereFollowsAlongItAndLeavesAtTheMouth) {
  reset(kSlitStart);
  Vec3 device = kSlitStart;
  for (int i = 1; i <= 200; ++i) {
    const Vec3 towards(0.01 * std::sin(0.1 * i), 0.003 + 0.0001 * i, -0.01 + 0.00003 * i);  // the walls hold it in x
    device = towards;
    const Vec3 probe = step(device);
    ASSERT_NEAR(probe.y(), device.y(), 1e-9) << i;
    ASSERT_NEAR(probe.z(), device.z(), 1e-9) << i;
    ASSERT_GT(probe.x(), 0.0) << i;
    ASSERT_LT(probe.x(), kSlitGap) << i;
  }
  for (int i = 1; i <= 100; ++i) (void)step(device + Vec3(0.0, 0.0, 0.0003 * i));
  EXPECT_FALSE(output_.contact) << "it has left";
  const Vec3 on_block = step({-0.01, 0.0, -0.002});
  EXPECT_NEAR(on_block.z(), kSlitProbeRadius, 1e-9) << "its whole radius counts again";
}

TEST_P(NarrowSlit, TheSphereStopsAtTheClosedEnd) {
  reset(kSlitStart);
  Vec3 probe = kSlitStart;
  for (int i = 1; i <= 100; ++i) probe = step({kSlitStart.x(), kSlitStart.y(), kSlitStart.z() - 0.0005 * i});
  EXPECT_NEAR(probe.z(), kEnd + kSlitStart.x(), 1e-9) << "its radius is the distance to the wall at the start";
  EXPECT_TRUE(output_.contact);
}

// The sphere crosses no wall, and moves no farther than the device, so that the force does not jump.
TEST_P(NarrowSlit, TheSphereComesNoNearerToTheWallsAndTheForceHasNoJump) {
  constexpr double kRounding = 1e-10;
  reset(kSlitStart);
  const double start_distance = distance_by_brute_force(kSlitStart);
  Vec3 device = kSlitStart;
  Vec3 last_probe = kSlitStart;
  int contact_steps = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vec3 to(uniform(-0.02, 0.02), uniform(-0.03, 0.03), uniform(-0.04, -0.005));
    const Vec3 moved = 0.02 * (to - device) + Vec3(uniform(-0.0005, 0.0005), 0.0, 0.0);
    device += moved;
    const Vec3 probe = step(device);
    contact_steps += output_.contact ? 1 : 0;
    ASSERT_GE(distance_by_brute_force(probe), start_distance - kRounding) << "step " << i;
    ASSERT_LE((probe - last_probe).norm(), moved.norm() + kRounding) << "step " << i;
    last_probe = probe;
  }
  EXPECT_GT(contact_steps, 500);
}

INSTANTIATE_TEST_SUITE_P(Seeds, NarrowSlit, testing::Range(1U, 41U));

class OnASurface : public ::testing::TestWithParam<unsigned> {};

// If the centre is exactly on an edge or a vertex, no direction leads away from it.
TEST_P(OnASurface, TheSphereIsNotHeldOnEdgesAndVertices) {
  std::mt19937_64 random(GetParam());
  RecordProperty("seed", std::to_string(GetParam()));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  TriangleMesh mesh = make_icosphere(0.05, 1);
  for (Vec3& vertex : mesh.vertices) vertex *= 1.0 + 0.2 * uniform(random);
  const auto shared = made::shared(mesh);
  const auto method = make_method({.name = "proxy", .probe_radius_m = kSlitProbeRadius}, {.objects = {{shared, {}}}}).value();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const double along : {0.0, 0.25, 0.5}) {
      const Vec3 start = (1.0 - along) * mesh.corner(i, 0) + along * mesh.corner(i, 1);
      for (const bool resumes : {false, true}) {
        resumes ? method->resume(start) : method->reset(start);
        const Vec3 away = start * (0.1 / start.norm());
        MethodOutput output;
        for (int k = 1; k <= 20; ++k) output = method->step({.p_SD = start + 0.05 * k * (away - start)});
        for (int k = 0; method->carried_from() && k < 64; ++k) output = method->step({.p_SD = away});
        EXPECT_FALSE(output.contact) << "triangle " << i << ", along " << along << (resumes ? ", resumed" : "");
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, OnASurface, testing::Values(1U, 2U));

// A tube along z that is narrower than the sphere, open at both ends, of many small triangles.
class FineTube : public ::testing::TestWithParam<unsigned> {
 protected:
  static constexpr double kTubeRadius = 0.8 * kSlitProbeRadius;
  static constexpr double kLength = 10.0 * kSlitProbeRadius;

  static TriangleMesh make_tube(std::mt19937_64& random) {
    constexpr std::uint32_t kAround = 48;
    constexpr std::uint32_t kAlong = 200;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i <= kAlong; ++i) {
      for (std::uint32_t k = 0; k < kAround; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / kAround;
        const double radius = kTubeRadius * (1.0 + 0.01 * uniform(random));
        mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), kLength * i / kAlong);
      }
    }
    for (std::uint32_t i = 0; i < kAlong; ++i) {
      for (std::uint32_t k = 0; k < kAround; ++k) {
        const std::uint32_t a = i * kAround + k;
        const std::uint32_t b = i * kAround + (k + 1) % kAround;
        mesh.triangles.push_back({a, a + kAround, b});
        mesh.triangles.push_back({b, a + kAround, b + kAround});
      }
    }
    return mesh;
  }
};

// The sphere overlaps hundreds of triangles, far more than it can have contacts: any motion that its contacts allow meets another triangle.
TEST_P(FineTube, TheSphereFollowsAlongItAndLeavesAtTheEnd) {
  std::mt19937_64 random(GetParam());
  RecordProperty("seed", std::to_string(GetParam()));
  const auto mesh = made::shared(make_tube(random));
  const auto method = make_method({.name = "proxy", .probe_radius_m = kSlitProbeRadius}, {.objects = {{mesh, {}}}}).value();
  const Vec3 start(0.0005, -0.0003, 0.5 * kLength);
  method->reset(start);
  MethodOutput output;
  int most_repeats = 0;
  for (int i = 1; i <= 100; ++i) {
    const Vec3 device(start.x() + 0.001 * std::sin(0.3 * i), start.y(), start.z() + 0.01 * i * kLength);
    output = method->step({.p_SD = device});
    int repeats = 0;
    for (; method->carried_from() && repeats < 256; ++repeats) output = method->step({.p_SD = device});
    most_repeats = std::max(most_repeats, repeats);
    if (i < 40) {
      EXPECT_NEAR(output.p_SP.z(), device.z(), kSlitProbeRadius) << i;
    }
  }
  EXPECT_LT(most_repeats, 256);
  EXPECT_FALSE(output.contact) << "it has left";
  RecordProperty("most_repeats", most_repeats);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FineTube, testing::Range(1U, 5U));

class NarrowTube : public ::testing::TestWithParam<unsigned> {};

// The sphere is put exactly in contact with a wall of a tube that is narrower than the sphere. Opposite walls are nearly parallel, so no
// position that is a radius away from both of them is near.
TEST_P(NarrowTube, TheSphereStaysNear) {
  std::mt19937_64 random(GetParam());
  RecordProperty("seed", std::to_string(GetParam()));
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    TriangleMesh mesh;
    for (const double y : {-5.663, 1.129, 7.921}) {
      for (const auto& [x, z] : {std::pair(-0.752, -1.03), {0.656, -1.458}, {1.121, 0.342}, {-0.289, 0.751}})
        mesh.vertices.emplace_back(kSlitProbeRadius * (Vec3(x, y, z) + 0.001 * Vec3(uniform(random), 0.0, uniform(random))));
    }
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t a = i;
      const std::uint32_t b = i % 4 == 3 ? i - 3 : i + 1;
      const bool is_other_diagonal = random() % 2 == 0;
      mesh.triangles.push_back({a, is_other_diagonal ? b : b + 4, is_other_diagonal ? a + 4 : b});
      mesh.triangles.push_back({b + 4, is_other_diagonal ? a + 4 : a, is_other_diagonal ? b : a + 4});
    }
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    mesh = joined(mesh, made::box(kSlitProbeRadius * Vec3(-10.6, -12.1, -5.5), kSlitProbeRadius * Vec3(-9.3, -8.6, -3.3)));
    const auto method = make_method({.name = "proxy", .probe_radius_m = kSlitProbeRadius}, {.objects = {{made::shared(mesh), {}}}}).value();
    const std::size_t wall = random() % 16;
    const Vec3& a = mesh.corner(wall, 0);
    const Vec3 along = mesh.corner(wall, 1) - a;
    const Vec3 across = mesh.corner(wall, 2) - a;
    Vec3 up = along.cross(across).normalized();
    if (up.dot(a - Vec3(0.0, a.y(), 0.0)) > 0.0) up = -up;
    const double share = uniform(random);
    const Vec3 start = a + share * along + uniform(random) * (1.0 - share) * across + kSlitProbeRadius * up;
    method->reset(start);
    Vec3 device = start;
    for (int i = 0; i < 20; ++i) {
      device += 0.001 * (Vec3(uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5) - (i == 0 ? up : Vec3(Vec3::Zero())));
      MethodOutput output = method->step({.p_SD = device});
      for (int k = 0; method->carried_from() && k < 64; ++k) output = method->step({.p_SD = device});
      ASSERT_LE((output.p_SP - start).norm(), 0.1) << "trial " << trial << ", step " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, NarrowTube, testing::Range(1U, 9U));

// Two sheets that cross at a very small angle, along the y axis; the lower one consists of many faces. The point is between them, at x > 0.
class NarrowWedge : public ::testing::TestWithParam<unsigned> {
 protected:
  static constexpr double kAngle = 0x1p-22;
  static constexpr double kHalfWidth = 0.05;
  static constexpr double kSphereRadius = 0x1p-31;  // of the sphere that stands for the point; the scene's unit is one metre
  static constexpr std::uint32_t kStrips = 150;

  static TriangleMesh make_sheets() {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i <= kStrips + 2; ++i) {
      const double x = i == 0 ? -0.5 : i > kStrips + 1 ? 0.5 : 0.4 * (i - 1) / kStrips;
      for (const double y : {-kHalfWidth, kHalfWidth}) mesh.vertices.emplace_back(x, y, 0.0);
    }
    for (std::uint32_t i = 0; i < 2 * (kStrips + 2); i += 2) {
      mesh.triangles.push_back({i, i + 2, i + 3});
      mesh.triangles.push_back({i, i + 3, i + 1});
    }
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const auto& [x, y] : {std::pair(-0.5, -kHalfWidth), {0.5, -kHalfWidth}, {0.5, kHalfWidth}, {-0.5, kHalfWidth}})
      mesh.vertices.emplace_back(x, y, kAngle * x);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    return mesh;
  }
};

// The point stays where the sphere that stands for it just fits between the sheets, although a sweep searches for a way on from there. It
// also stays if no work is left to go back, and far from the open ends of the sheets.
TEST_P(NarrowWedge, APointStaysWhereASweepGetsNoNearer) {
  std::mt19937_64 random(GetParam());
  RecordProperty("seed", std::to_string(GetParam()));
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const auto along = [&] { return uniform(-0.8 * kHalfWidth, 0.8 * kHalfWidth); };
  const auto method = make_method({.name = "proxy"}, {.objects = {{made::shared(make_sheets()), {}}}}).value();
  for (int trial = 0; trial < 100; ++trial) {
    const double from = uniform(0.02, 0.49);
    method->reset({from, along(), 0.5 * kAngle * from});
    for (int i = static_cast<int>(random() % 6); i > 0; --i) {
      const double x = uniform(0.02, 0.49);
      (void)method->step({.p_SD = {x, along(), -0.1}});
    }
    const double x = uniform(-0.4, -0.01);
    const double y = along();
    const Vec3 device(x, y, uniform(-0.3, -0.01));
    MethodOutput output = method->step({.p_SD = device});
    for (int k = 0; method->carried_from() && k < 64; ++k) output = method->step({.p_SD = device});
    EXPECT_NEAR(output.p_SP.x(), 2.0 * kSphereRadius / kAngle, 1e-5) << "trial " << trial;
    EXPECT_NEAR(output.p_SP.y(), device.y(), 1e-5) << "trial " << trial;
    EXPECT_NEAR(output.p_SP.z(), kSphereRadius, 0.01 * kSphereRadius) << "trial " << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, NarrowWedge, testing::Range(1U, 5U));

// Two blocks with a slit between them that is a little narrower than the sphere that stands for the point. The sphere stops at the mouth,
// held by two edges on nearly opposite sides. From there, a sweep that keeps no more distance than the sphere does gets through; a sweep
// with the usual distance would not.
TEST(APointInASlit, GoesThroughOneThatIsHardlyNarrowerThanItsSphere) {
  constexpr double kSphereRadius = 0x1p-31;  // half a contact offset; the scene's unit is one metre
  const Vec3 device(-0.2, 0.03, 0.0);
  for (const double share : {0.98, 0.985, 0.99, 0.995}) {
    const double half = share * kSphereRadius;
    const TriangleMesh blocks =
        joined(made::box({-0.5, -0.05, half}, {0.0, 0.05, 0.5}), made::box({-0.5, -0.05, -0.5}, {0.0, 0.05, -half}));
    const auto method = make_method({.name = "proxy"}, {.objects = {{made::shared(blocks), {}}}}).value();
    method->reset({0.3, 0.03, 0.0});
    const MethodOutput output = method->step({.p_SD = device});
    EXPECT_FALSE(method->carried_from()) << share << ": it arrives in one step";
    EXPECT_FALSE(output.contact) << share << ": " << output.p_SP.transpose();
    EXPECT_EQ(output.p_SP, device) << share;
  }
}

// The corner at the origin between two faces of the floor and one of the ceiling: the three normals are in one plane within rounding. Any
// two of the faces hold the point nearly as well, so that it could alternate between them without end.
TEST(APointInASlit, StaysInACornerWhoseNormalsAreInOnePlaneWithinRounding) {
  constexpr double kSphereRadius = 0x1p-31;  // half a contact offset
  for (const double tilt : {0.25, 1.0, 4.0, 16.0}) {
    TriangleMesh mesh;
    const auto add = [&](double x, double z, double slope_x, double slope_z, double y) {
      mesh.vertices.emplace_back(x, y + tilt * (slope_x * x + slope_z * z), z);
    };
    for (const auto& [x, z] : {std::pair(-0.064, -0.5), {0.064, 0.5}, {-0.5, 0.0}}) add(x, z, -1.94e-7, 0.0, -kSphereRadius);
    add(0.5, 0.0, -6.9e-8, -1.6e-8, -kSphereRadius);
    for (const auto& [x, z] : {std::pair(-0.5, -0.5), {-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}}) add(x, z, 1e-8, 0.0, kSphereRadius);
    mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {4, 5, 6}, {4, 6, 7}};
    const auto method = make_method({.name = "proxy"}, {.objects = {{made::shared(mesh), {}}}}).value();
    method->reset(Vec3(0.3, -8e-9 * tilt, 0.05));
    Vec3 proxy;
    for (const Vec3& device : {Vec3(0.25, -7e-9 * tilt, 0.05), Vec3(-0.156, 0.1, 0.01), Vec3(-0.156, 0.1, -0.02)}) {
      proxy = method->step({.p_SD = device}).p_SP;
      for (int i = 0; method->carried_from() && i < 8; ++i) proxy = method->step({.p_SD = device}).p_SP;
      EXPECT_FALSE(method->carried_from()) << tilt;
    }
    EXPECT_LT(proxy.norm(), 1e-7) << tilt;
    // Only the sweeps of a smaller sphere, once for each sample and place.
    EXPECT_LE(dynamic_cast<ProxyMethod&>(*method).swept().counters().sweeps, 16U) << tilt;
  }
}

}  // namespace
}  // namespace hapton
