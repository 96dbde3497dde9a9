#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>

#include "core/force/evaluation/stress_body.h"
#include "core/force/force_method.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/point_in_mesh.h"
#include "core/geometry/seal_cracks.h"
#include "core/geometry/seam_mesh.h"

namespace hapton {
namespace {

constexpr double kTapStepM = 2e-4;  // the meshes are 0.1 m long
constexpr double kTapDepthM = 2e-3;

std::unique_ptr<ForceMethod> make_proxy(const TriangleMesh& mesh) {
  TouchScene scene;
  scene.objects.push_back({.mesh = std::make_shared<const TriangleMesh>(mesh), .material = {}});
  auto method = make_method({.name = "proxy"}, scene);
  EXPECT_TRUE(method);
  return std::move(*method);
}

// Whether a tap straight in from outside ends in contact.
bool tap_ends_in_contact(ForceMethod& method, const Vec3& at, const Vec3& up) {
  method.reset(at + 1e-3 * up);
  MethodOutput felt;
  for (double height = 1e-3; height > -kTapDepthM; height -= kTapStepM) felt = method.step({.p_SD = at + height * up});
  return felt.contact;
}

// A position on a seam of a cracked mesh, in the middle of the gap: at a vertex of the seam, or between two of its vertices.
struct Position {
  Vec3 at;
  Vec3 up;
};

// The gaps of make_torn(mesh) run along the mesh's edges.
std::vector<Position> draw_positions(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Position> positions;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t t = random() % mesh.triangles.size();
    const int k = static_cast<int>(random() % 3);
    const double share = i % 4 == 0 ? 0.0 : std::uniform_real_distribution<double>(0.1, 0.9)(random);
    const Vec3 at = mesh.corner(t, k) + share * (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k));
    positions.push_back({at, at.normalized()});
  }
  return positions;
}

// The fault that sealing removes: the proxy falls through each open crack that it meets, at any width.
TEST(SealedTouch, TapsFallThroughOpenCracksButNotThroughSealedOnes) {
  constexpr std::uint64_t kSeed = 20261121;
  const TriangleMesh whole = make_icosphere(0.05, 3);
  const std::vector<Position> positions = draw_positions(whole, 2000, kSeed);
  for (const double width : {1e-6, 1e-5}) {  // 1 and 10 micrometres: 1e-5 and 1e-4 of the extent
    const TriangleMesh torn = make_torn(whole, 0.9 * width);
    SealReport report;
    const TriangleMesh sealed = seal_cracks(torn, report);
    ASSERT_TRUE(count_edges(sealed).closed()) << report.describe();
    const auto open_method = make_proxy(torn);
    const auto sealed_method = make_proxy(sealed);
    std::size_t open_fall_throughs = 0;
    std::size_t sealed_fall_throughs = 0;
    for (const Position& place : positions) {
      open_fall_throughs += tap_ends_in_contact(*open_method, place.at, place.up) ? 0 : 1;
      sealed_fall_throughs += tap_ends_in_contact(*sealed_method, place.at, place.up) ? 0 : 1;
    }
    fmt::print("cracks {:g} m wide, seed {}: {} of {} taps fall through, {} when sealed\n", width, kSeed, open_fall_throughs,
               positions.size(), sealed_fall_throughs);
    EXPECT_EQ(open_fall_throughs, positions.size());
    EXPECT_EQ(sealed_fall_throughs, 0U);
  }
}

// Gaps at random, some wider than what is sealed: no tap falls through where the surface is closed, on seams and beside them.
TEST(SealedTouch, TapsFallThroughNowhereElseThanAtWideGaps) {
  const TriangleMesh whole = make_icosphere(0.05, 3);
  for (const std::uint64_t seed : {1U, 2U}) {
    SealReport report;
    const TriangleMesh sealed = seal_cracks(make_shaken(whole, 1.5e-5, seed), report);
    ASSERT_TRUE(report.has_sealed());
    const std::vector<std::uint8_t> at_boundary = find_boundary_vertices(sealed);
    const auto is_at_gap = [&](const Vec3& p) {
      return std::any_of(sealed.triangles.begin(), sealed.triangles.end(), [&](const Triangle& t) {
        for (int k = 0; k < 3; ++k) {
          if (at_boundary[t[k]] == 0 || at_boundary[t[(k + 1) % 3]] == 0) continue;
          const Vec3& a = sealed.vertices[t[k]];
          const Vec3& b = sealed.vertices[t[(k + 1) % 3]];
          if (closest_point(a, b, b, p).distance < 5.0 * report.tolerance) return true;
        }
        return false;
      });
    };
    const auto method = make_proxy(sealed);
    std::size_t taps = 0;
    std::size_t fall_throughs = 0;
    for (const Position& place : draw_positions(whole, 3000, seed)) {
      if (is_at_gap(place.at)) continue;
      ++taps;
      fall_throughs += tap_ends_in_contact(*method, place.at, place.up) ? 0 : 1;
    }
    fmt::print("gaps up to 1.5 times the sealed width, seed {}: {} of {} taps fall through\n", seed, fall_throughs, taps);
    EXPECT_GT(taps, 1500U);
    EXPECT_EQ(fall_throughs, 0U);
  }
}

// Slides along a seam and across it, at varying depth. The facets are up to a few tenths of a millimetre inside the sphere.
TEST(SealedTouch, SlidesAcrossSealedSeamsStayInContact) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const StressBody body = make_stress_body("sealed-ball");
    const auto method = make_proxy(body.touched);
    const PointInMesh solid(body.solid);
    std::size_t steps_inside = 0;
    std::size_t steps_without_contact = 0;
    for (int slide = 0; slide < 60; ++slide) {
      const double azimuth = std::uniform_real_distribution<double>(0.0, 6.28)(random);
      Vec3 at(std::cos(azimuth), std::sin(azimuth), 0.01 * normal(random));
      Vec3 along = Vec3(normal(random), normal(random), slide % 2 == 0 ? 0.02 * normal(random) : normal(random));
      method->reset(0.052 * at.normalized());
      for (double height = 1e-3; height > -kTapDepthM; height -= kTapStepM) method->step({.p_SD = (0.05 + height) * at.normalized()});
      for (int step = 0; step < 500; ++step) {
        along = (along - along.dot(at) * at).normalized();
        at = (at + 2e-3 * along).normalized();
        const double depth = 1e-3 * (1.0 + 0.9 * std::sin(0.1 * step));
        const Vec3 device = (0.05 - depth) * at;
        const bool has_contact = method->step({.p_SD = device}).contact;
        if (!solid.is_inside(device) || solid.compute_distance(device) < 1e-8) continue;
        ++steps_inside;
        steps_without_contact += has_contact ? 0 : 1;
      }
    }
    EXPECT_EQ(steps_without_contact, 0U) << "seed " << seed;
    EXPECT_GT(steps_inside, 20000U) << "seed " << seed;
  }
}

TEST(StressSealedBodies, AreClosed) {
  for (const std::string shape : {"tears", "star", "box", "ball", "waves"}) {
    for (const char* const width : {"-fine", ""}) {
      const StressBody body = make_stress_body("sealed-" + shape + width);
      EXPECT_TRUE(count_edges(body.touched).closed()) << body.name;
      EXPECT_NEAR(compute_bounds(body.touched).extent(), 0.1, 0.01) << body.name;
      EXPECT_GT(compute_volume(body.touched), 0.0) << body.name;
    }
  }
}

}  // namespace
}  // namespace hapton
