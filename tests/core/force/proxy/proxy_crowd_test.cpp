// A sphere among hundreds of triangles: it starts where it overlaps them on one side, and the work of its steps is bounded.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
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

constexpr double kCrowdRadius = 0.004;

double clearance_over(const TriangleMesh& mesh, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    least = std::min(least, ContactTriangle(mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2)).separation(p).distance);
  return least;
}

Mat3 random_turn(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double w = uniform(random);
  const double x = uniform(random);
  const double y = uniform(random);
  return Eigen::Quaterniond(w, x, y, uniform(random)).normalized().toRotationMatrix();
}

class OnOneSide : public ::testing::TestWithParam<unsigned> {
 protected:
  OnOneSide() : random_(GetParam()) { RecordProperty("seed", std::to_string(GetParam())); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  std::mt19937_64 random_;
};

// The surfaces that the sphere overlaps leave a direction in which it can go, although it has far fewer contacts than it overlaps
// triangles. It goes in that direction at once, with its own radius, and is then held like any other sphere.
TEST_P(OnOneSide, TheSphereLeavesTheOverlapWithItsOwnRadius) {
  for (const double rough : {0.0, 0.02, 0.1}) {
    for (const bool is_hollow : {false, true}) {
      // The facets are as long as a tenth of the sphere's radius.
      TriangleMesh mesh = made::sheet(3.0 * kCrowdRadius, 0.0, 60);
      for (Vec3& v : mesh.vertices) {
        if (is_hollow) v.z() += v.head<2>().squaredNorm() / (8.0 * kCrowdRadius);
        v += rough * 0.1 * kCrowdRadius * Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      }
      const Mat3 turn = random_turn(random_);
      for (Vec3& v : mesh.vertices) v = turn * v;
      const auto method = make_method({.name = "proxy", .probe_radius_m = kCrowdRadius}, {.objects = {{made::shared(mesh), {}}}}).value();
      auto& proxy = static_cast<ProxyMethod&>(*method);
      const Vec3 start =
          turn * Vec3(uniform(-0.5, 0.5) * kCrowdRadius, uniform(-0.5, 0.5) * kCrowdRadius, uniform(0.3, 0.9) * kCrowdRadius);
      method->reset(start);
      int carried_steps = 0;
      MethodOutput output;
      for (int i = 1; i <= 20; ++i) {
        const Vec3 device = start + 0.02 * i * kCrowdRadius * (turn * Vec3(1.0, 0.3, -1.0));
        output = method->step({.p_SD = device});
        for (int k = 0; method->carried_from() && k < 256; ++k, ++carried_steps) output = method->step({.p_SD = device});
        ASSERT_FALSE(proxy.swept().is_shrunk()) << "rough " << rough << ", hollow " << is_hollow << ", step " << i;
      }
      EXPECT_GE(clearance_over(mesh, output.p_SP), kCrowdRadius * (1.0 - 1e-6)) << "rough " << rough << ", hollow " << is_hollow;
      EXPECT_LE((output.p_SP - start).norm(), 3.0 * kCrowdRadius);
      EXPECT_LE(carried_steps, 200);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, OnOneSide, testing::Range(1U, 13U));

// Meshes with thousands of triangles within the reach of a sphere.
TriangleMesh star_of_spokes(std::mt19937_64& random) {
  constexpr std::uint32_t kSpokes = 3000;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  TriangleMesh mesh;
  mesh.vertices.push_back(Vec3(0.0, 0.0, 0.01 * uniform(random)));
  for (std::uint32_t i = 0; i < kSpokes; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSpokes;
    const double far = 0.05 * (1.0 + 0.2 * uniform(random));
    mesh.vertices.emplace_back(far * std::cos(angle), far * std::sin(angle), 0.001 * uniform(random));
    mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % kSpokes});
  }
  return mesh;
}

TriangleMesh book_of_pages(std::mt19937_64& random) {
  constexpr std::uint32_t kPages = 3000;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0.0, 0.0, -0.05), Vec3(0.0, 0.0, 0.05)};
  for (std::uint32_t i = 0; i < kPages; ++i) {
    const double angle = std::numbers::pi * uniform(random);
    mesh.vertices.emplace_back(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.05 * uniform(random));
    mesh.triangles.push_back({0, 1, 2 + i});
  }
  return mesh;
}

TriangleMesh dense_soup(double size, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 8000; ++i) {
    const Vec3 at = 0.03 * vector();
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(at + size * vector());
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

class AmongThousands : public ::testing::TestWithParam<unsigned> {};

// What a sphere cannot do with the work of one step is left to the next steps.
TEST_P(AmongThousands, NoStepDoesMoreThanItsWork) {
  std::mt19937_64 random(GetParam());
  RecordProperty("seed", std::to_string(GetParam()));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const std::pair<const char*, TriangleMesh> meshes[] = {{"star", star_of_spokes(random)},
                                                         {"book", book_of_pages(random)},
                                                         {"soup", dense_soup(0.002, random)},
                                                         {"coarse soup", dense_soup(0.02, random)},
                                                         {"noise", make_bumpy_sphere(0.03, 0.02, 60000, GetParam())}};
  for (const auto& [name, mesh] : meshes) {
    for (const double friction : {0.0, 0.5}) {
      TouchScene scene{.objects = {{made::shared(mesh), {}}}};
      scene.objects[0].material.friction_static = friction;
      scene.objects[0].material.friction_dynamic = 0.8 * friction;
      for (const double radius_m : {0.0, 0.002, 0.01}) {
        const auto method = make_method({.name = "proxy", .probe_radius_m = radius_m}, scene).value();
        auto& proxy = static_cast<ProxyMethod&>(*method);
        for (const bool begins_inside : {false, true}) {
          Vec3 device = begins_inside ? Vec3(0.01 * uniform(random), 0.01 * uniform(random), 0.01 * uniform(random)) : Vec3(0.0, 0.0, 0.1);
          method->reset(device);
          for (int i = 0; i < 16; ++i) {
            device += i % 8 == 0 ? Vec3(0.02 * Vec3(uniform(random), uniform(random), uniform(random)) - 0.3 * device)
                                 : Vec3(0.001 * Vec3(uniform(random), uniform(random), uniform(random)));
            (void)method->step({.p_SD = device});
            for (int k = 0; method->carried_from() && k < 32; ++k) {  // the hand goes on meanwhile
              device += 1e-5 * Vec3(uniform(random), uniform(random), uniform(random));
              (void)method->step({.p_SD = device});
            }
          }
        }
        EXPECT_LE(proxy.counters().most_work, StepWork::kMaxWithLastEvent / 2)
            << name << ", radius " << radius_m << ", friction " << friction;
        RecordProperty(std::string(name) + " " + std::to_string(radius_m) + " " + std::to_string(friction),
                       std::to_string(proxy.counters().most_work) + " units");
      }
    }
  }
}

// A step that runs out of work between two contacts ends without any; its force must not have the stiffness of the far object.
TEST_P(AmongThousands, NoStepHasTheStiffnessOfAnotherObject) {
  std::mt19937_64 random(GetParam());
  RecordProperty("seed", std::to_string(GetParam()));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const TriangleMesh far = scaled_and_moved(make_box({0.01, 0.01, 0.01}, 1), 1.0, {0.5, 0.0, 0.0});
  int carried_steps = 0;
  for (const TriangleMesh& mesh : {star_of_spokes(random), book_of_pages(random), dense_soup(0.002, random), dense_soup(0.02, random)}) {
    TouchScene scene{.objects = {{made::shared(far), {}}, {made::shared(mesh), {}}}};
    scene.objects[0].material.stiffness_n_per_m = 1e4;
    scene.objects[1].material.stiffness_n_per_m = 100.0;
    for (const double radius_m : {0.0, 0.002, 0.01}) {
      const auto method = make_method({.name = "proxy", .probe_radius_m = radius_m}, scene).value();
      Vec3 device(0.0, 0.0, 0.1);
      method->reset(device);
      for (int i = 0; i < 100; ++i) {
        device += i % 8 == 0 ? Vec3(0.02 * Vec3(uniform(random), uniform(random), uniform(random)) - 0.3 * device)
                             : Vec3(0.001 * Vec3(uniform(random), uniform(random), uniform(random)));
        const MethodOutput output = method->step({.p_SD = device});
        carried_steps += method->carried_from() ? 1 : 0;
        ASSERT_LE(output.force_n.norm(), 100.0 * (1.0 + 1e-9) * (output.p_SP - device).norm()) << "radius " << radius_m << ", step " << i;
        ASSERT_NE(output.object, 0);
      }
    }
  }
  EXPECT_GT(carried_steps, 10) << "no step ran out of work";
}

INSTANTIATE_TEST_SUITE_P(Seeds, AmongThousands, testing::Values(1U, 2U));

// The boxes of thousands of slanted triangles contain the whole sphere, but it touches none of the triangles.
class OverSlantedTriangles : public ::testing::TestWithParam<unsigned> {
 protected:
  OverSlantedTriangles() : random_(GetParam()) { RecordProperty("seed", std::to_string(GetParam())); }
  TriangleMesh slanted_triangles() const {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < 2000; ++i) {
      for (int k = 0; k < 3; ++k) mesh.vertices.push_back(0.1 * Vec3::Unit(k) - (1e-6 * i) * up_);
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
  }
  static std::unique_ptr<ForceMethod> make(const TriangleMesh& mesh) {
    return make_method({.name = "proxy", .probe_radius_m = kCrowdRadius}, {.objects = {{made::shared(mesh), {}}}}).value();
  }
  double uniform(double most) { return std::uniform_real_distribution<double>(-most, most)(random_); }
  Vec3 random_vector_across_up(double most) {
    const double x = uniform(most);
    const double y = uniform(most);
    const Vec3 any(x, y, uniform(most));
    return any - any.dot(up_) * up_;
  }

  const Vec3 up_ = Vec3::Ones().normalized();
  const Vec3 middle_ = Vec3::Constant(0.1 / 3.0);  // of the topmost triangle
  std::mt19937_64 random_;
};

TEST_P(OverSlantedTriangles, TheSphereArrivesInFreeSpace) {
  const auto method = make(slanted_triangles());
  const auto random_position = [&] { return Vec3(middle_ + 1.2 * kCrowdRadius * up_ + random_vector_across_up(0.01)); };
  method->reset(random_position());
  for (int i = 0; i < 40; ++i) {
    const Vec3 device = random_position();
    MethodOutput output = method->step({.p_SD = device});
    int repeats = 0;
    for (; method->carried_from() && repeats < 64; ++repeats) output = method->step({.p_SD = device});
    ASSERT_LT(repeats, 64) << i;
    EXPECT_FALSE(output.contact) << i;
  }
}

// The work of a step includes what it examines before the proxy follows.
TEST_P(OverSlantedTriangles, AStepCountsAllOfItsWork) {
  const auto method = make(slanted_triangles());
  method->reset(middle_ + 1.2 * kCrowdRadius * up_);
  (void)method->step({.p_SD = middle_ + 1.2 * kCrowdRadius * up_});
  EXPECT_GT(static_cast<const ProxyMethod&>(*method).counters().most_work, 256) << "the search for an empty ball";
}

// The edge of a fin holds the sphere while the device, close to the edge, goes around it. Here only sweeps move the sphere. Motions along
// the tangent of the pull alone would each reduce the distance by a fifth, and take a hundred sweeps.
TEST_P(OverSlantedTriangles, FewSweepsLeadAroundAnEdge) {
  constexpr double kNear = 0.2 * kCrowdRadius;  // distance from the device to the edge
  const Vec3 edge = middle_ + 3.0 * kCrowdRadius * up_;
  const Vec3 along = random_vector_across_up(1.0).normalized();
  const Vec3 side = along.cross(up_);
  TriangleMesh mesh = slanted_triangles();
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {edge - 0.02 * along, edge + 0.02 * along, edge + 0.02 * up_});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const auto method = make(mesh);
  const auto& proxy = static_cast<const ProxyMethod&>(*method);
  const auto around = [&](double turn) { return Vec3(std::sin(turn) * side - std::cos(turn) * up_); };
  method->reset(edge + 1.5 * kCrowdRadius * around(0.0));
  for (int i = 0; i < 20; ++i) {
    const Vec3 out = around(uniform(1.0));
    const Vec3 device = edge + kNear * out + uniform(0.001) * along;
    const std::uint64_t sweeps = proxy.swept().counters().sweeps;
    MethodOutput output = method->step({.p_SD = device});
    for (int k = 0; method->carried_from() && k < 1000; ++k) output = method->step({.p_SD = device});
    EXPECT_LE(proxy.swept().counters().sweeps - sweeps, 32U) << i;
    EXPECT_LT((output.p_SP - device - (kCrowdRadius - kNear) * out).norm(), 1e-7 * kCrowdRadius) << i;
  }
  EXPECT_GT(proxy.swept().counters().sweeps, 20U);
}

// Over a fine surface, the box of a long path contains thousands of triangles, the box of the sphere alone only a few. A flight that has
// given up is not tried again in each step of the same motion: sweeps, which can be interrupted, finish that motion.
TEST_P(OverSlantedTriangles, AFlightGivesUpOnceInAMotion) {
  TriangleMesh mesh = made::sheet(0.05, 0.0, 250);
  const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), up_).toRotationMatrix();
  for (Vec3& v : mesh.vertices) v = turn * v;
  const auto method = make(mesh);
  const auto& proxy = static_cast<const ProxyMethod&>(*method);
  const auto above = [&] {
    const double x = uniform(0.03);
    return Vec3(turn * Vec3(x, uniform(0.03), 1.2 * kCrowdRadius));
  };
  Vec3 device = above();
  method->reset(device);
  int carried_steps = 0;
  for (int i = 0; i < 40; ++i) {
    const Vec3 goal = above();
    const Vec3 motion = (goal - device) / 8.0;
    // The device goes on while its motion is carried.
    for (int k = 0; k < 64 && (k < 8 || method->carried_from()); ++k) {
      if (k < 8) device += motion;
      const bool is_carried = method->carried_from().has_value();
      const std::uint64_t flights = proxy.sphere().flights();
      (void)method->step({.p_SD = device});
      carried_steps += is_carried ? 1 : 0;
      EXPECT_LE(proxy.sphere().flights() - flights, is_carried ? 0U : 1U) << i << ", " << k;
    }
    EXPECT_FALSE(method->carried_from()) << i;
  }
  RecordProperty("carried", carried_steps);
  EXPECT_GT(carried_steps, 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, OverSlantedTriangles, testing::Values(1U, 2U));

}  // namespace
}  // namespace hapton
