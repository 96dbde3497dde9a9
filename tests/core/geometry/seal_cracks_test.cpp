#include "core/geometry/seal_cracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "core/geometry/boundary_edges.h"
#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/seam_mesh.h"
#include "tests/support/made_meshes.h"
#include "tests/support/sealed_invariants.h"

namespace hapton {
namespace {

using made::are_equal;
using made::seal_checked;
using ::testing::HasSubstr;

constexpr double kWidths[] = {1e-12, 1e-9, 1e-6, 1e-5, 0.9e-4};  // for meshes about 1 long

void expect_closed(const TriangleMesh& mesh, const std::string& what) {
  const made::Sealed sealed = seal_checked(mesh, what);
  EXPECT_GT(sealed.report.boundary_edges, 0U) << what;
  EXPECT_TRUE(compute_mesh_topology(sealed.mesh).is_closed()) << what << ": " << sealed.report.describe();
}

TEST(SealCracks, LeavesClosedMeshesUnchanged) {
  for (const TriangleMesh& mesh : {make_icosphere(0.5, 3), make_box(Vec3(1.0, 0.8, 0.6), 3), make_bumpy_sphere(0.5, 0.25, 5000, 1),
                                   make_thin_wall(1.0, 1e-5, 4), make_thin_wall(1.0, 1e-9, 1), make_cylinder(0.5, 0.02, 3000)}) {
    const made::Sealed sealed = seal_checked(mesh, "closed");
    EXPECT_FALSE(sealed.report.has_sealed());
    EXPECT_TRUE(are_equal(sealed.mesh, mesh));
    SealReport report;
    std::vector<std::uint32_t> source;
    seal_cracks(mesh, report, kSealedShare, &source);
    ASSERT_EQ(source.size(), mesh.triangles.size());
    EXPECT_EQ(source.back(), mesh.triangles.size() - 1);
  }
}

TEST(SealCracks, ClosesWhatWasTornAtEveryEdge) {
  for (const double width : kWidths) {
    expect_closed(make_torn(make_icosphere(0.5, 3), width), fmt::format("ball {:g}", width));
    expect_closed(make_torn(make_box(Vec3(1.0, 0.8, 0.6), 3), width), fmt::format("box {:g}", width));
    expect_closed(make_torn(make_bumpy_sphere(0.45, 0.25, 5000, 1), width), fmt::format("bumps {:g}", width));
  }
}

struct SeamGaps {
  std::size_t narrow = 0;  // no wider than the tolerance at both ends
  std::size_t wide = 0;
};

// `apart` has the triangles of `whole`, each with its own vertices.
SeamGaps count_seams(const TriangleMesh& whole, const TriangleMesh& apart, double tolerance) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<Vec3, 2>> first_side;
  SeamGaps gaps;
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    const auto corner_of = [&](std::size_t k) { return apart.vertices[apart.triangles[t][k]]; };
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const bool is_forward = whole.triangles[t][k] < whole.triangles[t][next];
      const std::array<Vec3, 2> ends = {corner_of(is_forward ? k : next), corner_of(is_forward ? next : k)};
      const auto [side, is_first] = first_side.try_emplace(std::minmax(whole.triangles[t][k], whole.triangles[t][next]), ends);
      if (is_first) continue;
      const double gap = std::max((side->second[0] - ends[0]).norm(), (side->second[1] - ends[1]).norm());
      ++(gap <= tolerance ? gaps.narrow : gaps.wide);
    }
  }
  return gaps;
}

TEST(SealCracks, ClosesGapsAndOverlapsOfRandomWidth) {
  for (const double width : kWidths) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const auto what = [&](const char* name) { return fmt::format("{} {:g}, seed {}", name, width, seed); };
      expect_closed(make_shaken(make_icosphere(0.5, 3), width, seed), what("ball"));
      expect_closed(make_shaken(make_bumpy_sphere(0.45, 0.25, 5000, 1), width, seed), what("bumps"));
      expect_closed(make_shaken(make_thin_wall(1.0, 0.01, 6), width, seed), what("wall"));
    }
  }
}

// Random gaps, some of them too wide to be sealed: all others are sealed, wherever they are. Each edge of the whole mesh is a seam.
TEST(SealCracks, WideGapsDoNotKeepNarrowOnesOpen) {
  const TriangleMesh box = make_box(Vec3(1.0, 1.0, 1.0), 5);
  const TriangleMesh ball = make_icosphere(0.5, 3);
  for (const double width : {1.2e-4, 1.5e-4}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      for (const TriangleMesh* whole : {&box, &ball}) {
        const TriangleMesh shaken = make_shaken(*whole, width, seed);
        const made::Sealed sealed = seal_checked(shaken, fmt::format("{:g}, seed {}", width, seed));
        const SeamGaps gaps = count_seams(*whole, shaken, sealed.report.tolerance);
        EXPECT_FALSE(sealed.report.has_given_up);
        EXPECT_GT(gaps.narrow, 0U);
        EXPECT_LE(sealed.report.boundary_edges_left, 2 * gaps.wide) << gaps.narrow << " narrow seams; " << sealed.report.describe();
      }
    }
  }
}

// T-junctions are along each edge of the box and along the equator of the spheres, whose meridians have cracks only.
TEST(SealCracks, ClosesTJunctionsBetweenSheetsCutApart) {
  for (const double width : kWidths) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      expect_closed(make_patched_box(Vec3(1.0, 0.8, 0.6), width, seed), fmt::format("box {:g}, seed {}", width, seed));
      if (width < 1e-6) continue;  // chords as short as that take millions of triangles
      expect_closed(make_patched_sphere(0.5, 0.0, width, seed), fmt::format("sphere {:g}, seed {}", width, seed));
      expect_closed(make_patched_sphere(0.45, 0.1, width, seed), fmt::format("waves {:g}, seed {}", width, seed));
    }
  }
}

TEST(SealCracks, DoesNotDependOnScaleAndPlace) {
  const TriangleMesh mesh = make_patched_box(Vec3(1.0, 0.8, 0.6), 0.5e-4, 4);
  const made::Sealed sealed = seal_checked(mesh, "at the origin");
  for (const double scale : {1e-3, 1e-6, 1e3, 1e6}) {
    const made::Sealed scaled = seal_checked(scaled_and_moved(mesh, scale, Vec3::Zero()), "scaled");
    EXPECT_EQ(scaled.mesh.triangles, sealed.mesh.triangles) << scale;
  }
  for (const double offset : {10.0, 1e3, 1e6}) {
    const made::Sealed moved = seal_checked(scaled_and_moved(mesh, 1.0, offset * Vec3(1.0, -1.0, 1.0)), "moved");
    EXPECT_EQ(moved.mesh.triangles, sealed.mesh.triangles) << offset;
  }
}

// The result is the same whichever corner of a triangle comes first. In these boxes several passes would distort split triangles too much,
// and the edges that caused this are excluded.
TEST(SealCracks, DoesNotDependOnTheFirstCornersOfTriangles) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    TriangleMesh mesh = make_shaken(make_box(Vec3(1.0, 1.0, 1.0), 5), 1.5e-4, seed);
    SealReport first_report;
    const TriangleMesh sealed = seal_cracks(mesh, first_report);
    ASSERT_TRUE(first_report.has_sealed()) << seed;
    for (int turn = 1; turn <= 2; ++turn) {
      for (Triangle& t : mesh.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
      SealReport report;
      const TriangleMesh rotated = seal_cracks(mesh, report);
      EXPECT_EQ(rotated.vertices, sealed.vertices) << seed;
      EXPECT_EQ(report.split_triangles, first_report.split_triangles) << seed;
      EXPECT_EQ(report.zipped_edges, first_report.zipped_edges) << seed;
      EXPECT_EQ(report.boundary_edges_left, first_report.boundary_edges_left) << seed;
      EXPECT_EQ(report.widest_gap, first_report.widest_gap) << seed;
    }
  }
}

TEST(SealCracks, AThinPlateKeepsItsTwoSides) {
  // The plate is thinner than the tolerance; the cracks along its edges are narrower than the plate is thick.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const TriangleMesh plate = make_shaken(make_box(Vec3(1.0, 0.8, 5e-5), 1), 1e-5, seed);
    expect_closed(plate, fmt::format("seed {}", seed));
    SealReport report;
    EXPECT_NEAR(compute_volume(seal_cracks(plate, report)), 0.8 * 5e-5, 0.2 * 0.8 * 5e-5);
  }
}

TriangleMesh two_sheets(const Vec3& between, int cells) {
  return joined(make_plane_grid(1.0, cells), scaled_and_moved(make_plane_grid(1.0, cells), 1.0, between));
}

TEST(SealCracks, SheetsCloseTogetherKeepTheirInnerVertices) {
  const TriangleMesh sheets =
      joined(make_plane_grid(1.0, 8), scaled_and_moved(flipped(make_plane_grid(1.0, 8)), 1.0, Vec3(0.0, 0.0, 5e-5)));
  const made::Sealed sealed = seal_checked(sheets, "two sheets");
  // Rims may be joined; each inner vertex still exists, once in each sheet.
  std::size_t inner = 0;
  for (const Vec3& vertex : sealed.mesh.vertices) inner += vertex.head<2>().cwiseAbs().maxCoeff() < 0.49 ? 1 : 0;
  EXPECT_EQ(inner, 2U * 7U * 7U);
  EXPECT_NEAR(compute_area(sealed.mesh), 2.0, 1e-3);
}

TEST(SealCracks, OpenSheetsStayOpen) {
  for (const TriangleMesh& mesh : {make_plane_grid(1.0, 8), two_sheets(Vec3(1.001, 0.0, 0.0), 8), two_sheets(Vec3(1.0, 0.0, 3e-4), 8),
                                   two_sheets(Vec3(0.3, 0.2, 5e-5), 8), two_sheets(Vec3(1.00005, 1.00005, 0.0), 8)}) {
    EXPECT_FALSE(seal_checked(mesh, "open").report.has_sealed());
  }
}

TEST(SealCracks, ANarrowStripStays) {
  // A ribbon narrower than the tolerance, its sides with vertices in different places; and one with a row of vertices along its middle.
  TriangleMesh ribbon;
  for (int i = 0; i <= 40; ++i) ribbon.vertices.emplace_back((i + (i % 2 == 0 ? 0.0 : 0.3)) / 40.0, i % 2 == 0 ? 0.0 : 0.5e-4, 0.0);
  for (std::uint32_t i = 0; i + 2 <= 40; ++i)
    ribbon.triangles.push_back(i % 2 == 0 ? Triangle{i, i + 2, i + 1} : Triangle{i, i + 1, i + 2});
  EXPECT_FALSE(seal_checked(ribbon, "ribbon").report.has_sealed());
  TriangleMesh wide = make_plane_grid(1.0, 10);
  std::erase_if(wide.triangles, [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return std::fabs(wide.vertices[v].y()) > 0.11; });
  });
  for (Vec3& vertex : wide.vertices) vertex.y() *= 4e-4;
  EXPECT_FALSE(seal_checked(wide, "ribbon with a middle").report.has_sealed());
}

// A square cut from its left side to its middle, `width` wide at the rim.
TriangleMesh notched(double width, int cells_above, int cells_below) {
  TriangleMesh sheet;
  const auto half = [&](double side, int cells) {
    TriangleMesh part = make_plane_grid(1.0, cells);
    for (Vec3& v : part.vertices) {
      const double along = v.x() + 0.5;  // 0 to 1
      const double gap = 0.5 * width * std::max(0.0, 1.0 - 2.0 * along);
      v.y() = side * (gap + (v.y() + 0.5) * 0.5);
    }
    return side > 0.0 ? part : flipped(part);
  };
  return joined(half(1.0, cells_above), half(-1.0, cells_below));
}

TEST(SealCracks, ANotchIsNotZippedUpFromItsTip) {
  for (const auto& [above, below] : {std::pair(64, 64), std::pair(64, 4), std::pair(150, 2), std::pair(100, 150)}) {
    const made::Sealed sealed = seal_checked(notched(0.2, above, below), fmt::format("{} and {} cells", above, below));
    // The half beyond the tip is closed. The outline, about 4 long, and the notch, two sides of 0.5 each, stay.
    double open_vertices = 0.0;
    const std::vector<std::uint8_t> at_boundary = find_boundary_vertices(sealed.mesh);
    double notch_end_x = 0.0;
    for (std::size_t v = 0; v < at_boundary.size(); ++v) {
      const Vec3& p = sealed.mesh.vertices[v];
      if (at_boundary[v] != 0 && std::fabs(p.y()) < 0.11 && p.x() > -0.499) notch_end_x = std::max(notch_end_x, p.x());
      open_vertices += at_boundary[v];
    }
    EXPECT_GT(open_vertices, 0.0);
    EXPECT_GT(notch_end_x, -0.05);
    EXPECT_LT(sealed.report.widest_gap, 1.01 * sealed.report.tolerance);
    EXPECT_NEAR(compute_area(sealed.mesh), 1.0, 1e-3);
  }
}

TEST(SealCracks, AWiderSlitStaysAndANarrowerOneCloses) {
  const auto slit = [](double width) {
    TriangleMesh sheets = two_sheets(Vec3(1.0 + width, 0.0, 0.0), 8);
    return sheets;
  };
  const double extent = 2.0;
  EXPECT_EQ(seal_checked(slit(0.9e-4 * extent), "narrow").report.zipped_edges, 8U);
  EXPECT_FALSE(seal_checked(slit(1.1e-4 * extent), "wide").report.has_sealed());
}

TEST(SealCracks, FlippedPatchesAreJoinedAndStayFlipped) {
  TriangleMesh box = make_patched_box(Vec3(1.0, 0.8, 0.6), 0.5e-4, 1);
  for (std::size_t t = 0; t < 2U * 3U * 3U; ++t) std::swap(box.triangles[t][1], box.triangles[t][2]);
  const made::Sealed sealed = seal_checked(box, "flipped face");
  const EdgeCensus edges = count_edges(sealed.mesh);
  EXPECT_EQ(edges.boundary, 0U);
  EXPECT_EQ(edges.non_manifold, 0U);
  EXPECT_GT(edges.inconsistent, 0U);
}

TEST(SealCracks, AuthoredNormalsGoWithTheirCorners) {
  TriangleMesh box = make_patched_box(Vec3(1.0, 0.8, 0.6), 0.5e-4, 1);
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    const Eigen::Vector3f normal = made::normal_of(box, t).normalized().cast<float>();
    box.authored_normals.push_back({normal, normal, normal});
  }
  const made::Sealed sealed = seal_checked(box, "with normals");
  ASSERT_TRUE(sealed.mesh.has_authored_normals());
  EXPECT_GT(sealed.report.split_triangles, 0U);
  for (std::size_t t = 0; t < sealed.mesh.triangles.size(); ++t) {
    for (const Eigen::Vector3f& normal : sealed.mesh.authored_normals[t])
      EXPECT_GT(normal.cast<double>().dot(made::normal_of(sealed.mesh, t).normalized()), 0.99);
  }
}

TEST(SealCracks, ClosesAFanOfThousandsOfSeparateSlivers) {
  // A fan of slivers, each separate from the next, with their tips in one place.
  for (const double width : {1e-9, 1e-5, 0.9e-4})
    expect_closed(make_shaken(make_cylinder(0.5, 0.02, 3000), width, 1), fmt::format("{:g}", width));
}

TEST(SealCracks, SaysInOneLineWhatItDid) {
  const made::Sealed sealed = seal_checked(make_patched_box(Vec3(1.0, 0.8, 0.6), 0.5e-4, 1), "box");
  const std::string line = sealed.report.describe();
  EXPECT_THAT(line, HasSubstr("sealed cracks up to"));
  EXPECT_THAT(line, HasSubstr(fmt::format("welded {} vertices", sealed.report.welded_vertices)));
  EXPECT_EQ(line.find('\n'), std::string::npos);
}

TEST(SealCracks, SaysWhatItLeavesAndHowWideThatIs) {
  const TriangleMesh shaken = make_shaken(make_box(Vec3(1.0, 1.0, 1.0), 5), 1.5e-4, 1);
  const made::Sealed sealed = seal_checked(shaken, "box");
  const BoundaryEdges remaining = count_boundary_edges(sealed.mesh, sealed.report.tolerance);
  ASSERT_GT(remaining.cracks, 0U);
  EXPECT_EQ(sealed.report.unsealed_edges, remaining.cracks);
  EXPECT_GT(sealed.report.widest_unsealed, 0.0);
  EXPECT_LE(sealed.report.widest_unsealed, sealed.report.tolerance);
  EXPECT_THAT(sealed.report.describe(), HasSubstr(fmt::format("{} of them are at cracks up to {:.3g} m wide: closing them would move",
                                                              remaining.cracks, remaining.widest_crack)));
}

// Random triangles of several densities: in the densest, thousands of vertices and edges lie within one tolerance.
TEST(SealCracks, KeepsItsInvariantsOnSoups) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    for (const double size : {0.2, 1e-2, 1e-3, 1e-4, 1e-5}) {
      TriangleMesh soup = made::soup(seed, 1500, std::max(20.0 * size, 1e-3), size);
      soup.vertices.emplace_back(1.0, 0.0, 0.0);  // an extent of at least 1
      soup.vertices.emplace_back(0.0, 0.0, 0.0);
      seal_checked(soup, fmt::format("soup of {:g}, seed {}", size, seed));
    }
  }
}

// A mesh with a few vertices so far out that all the rest lies within one tolerance: nothing can be sealed. The sealing gives up, and the
// mesh is returned unchanged.
TEST(SealCracks, LeavesAMeshWithinOneToleranceUnchanged) {
  TriangleMesh soup = made::soup(1, 20000, 1e-5, 1e-5);
  for (std::size_t i = 0; i < soup.vertices.size(); i += 500) soup.vertices[i] += Vec3(1.0, 0.0, 0.0);
  SealReport report;
  std::vector<std::uint32_t> source;
  const TriangleMesh sealed = seal_cracks(soup, report, kSealedShare, &source);
  EXPECT_TRUE(report.has_given_up);
  EXPECT_FALSE(report.has_sealed());
  EXPECT_TRUE(are_equal(sealed, soup));
  ASSERT_EQ(source.size(), soup.triangles.size());
  for (std::size_t t = 0; t < source.size(); ++t) ASSERT_EQ(source[t], t);
  EXPECT_EQ(report.boundary_edges, 60000U) << "every edge of the loose triangles";
  EXPECT_EQ(report.boundary_edges_left, report.boundary_edges);
  EXPECT_THAT(report.describe(), HasSubstr("cracks not sealed: its 60000 boundary edges lie too close together"));
}

// A stray vertex makes the tolerance as large as the triangles are, so that joining some moves others, everywhere. Without giving
// up, the excluded parts would grow until they cover everything: in 33 passes, which take 5 s.
TEST(SealCracks, GivesUpWhereExcludedPartsWouldCoverTheMesh) {
  TriangleMesh soup = made::soup(1, 10000, 1.0, 0.01);
  soup.vertices[0].x() = 100.0;
  SealReport report;
  const TriangleMesh sealed = seal_cracks(soup, report);
  EXPECT_TRUE(report.has_given_up);
  EXPECT_TRUE(are_equal(sealed, soup));
  EXPECT_THAT(report.describe(), HasSubstr("cracks not sealed"));
}

// A sphere with random damage: holes, copies, flipped and torn triangles, edges with three triangles, triangles with a repeated vertex.
TriangleMesh damaged(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  TriangleMesh mesh = make_bumpy_sphere(0.5, 0.2, 1000, seed);
  const std::size_t count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    Triangle t = mesh.triangles[i];
    const double choice = uniform(random);
    if (choice < 0.05) {
      mesh.triangles[i] = {t[0], t[0], t[1]};
    } else if (choice < 0.10) {
      mesh.triangles.push_back(t);
    } else if (choice < 0.15) {
      std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    } else if (choice < 0.20) {
      mesh.vertices.push_back(mesh.vertices[t[0]] + Vec3(0.0, 0.0, 0.05));
      mesh.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
    } else if (choice < 0.45) {
      for (std::uint32_t& v : t) {
        const Vec3 move(uniform(random), uniform(random), uniform(random));
        mesh.vertices.push_back(mesh.vertices[v] + 5e-5 * (move - Vec3::Constant(0.5)));
        v = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
      }
      mesh.triangles[i] = t;
    } else if (choice < 0.5) {
      mesh.vertices.push_back(0.5 * (mesh.vertices[t[0]] + mesh.vertices[t[1]]));
      const auto middle = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
      mesh.triangles[i] = {t[0], middle, t[2]};
      mesh.triangles.push_back({middle, t[1], t[2]});
    }
  }
  return mesh;
}

TEST(SealCracks, KeepsItsInvariantsOnDamagedMeshes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const made::Sealed sealed = seal_checked(damaged(seed), fmt::format("seed {}", seed));
    EXPECT_LT(10 * sealed.report.boundary_edges_left, 7 * sealed.report.boundary_edges) << seed;
  }
}

}  // namespace
}  // namespace hapton
