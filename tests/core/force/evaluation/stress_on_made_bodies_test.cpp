// Episodes of the stress test that once found a fault: on closed bodies that cross themselves or whose triangles differ in size a
// thousandfold, on bodies with displaced copies of their faces, on blades, and on gyroids with needles. The seed determines the body, the
// place and the motions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/force/evaluation/stress_run.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double least, double most) { return least + (most - least) * 0x1p-64 * static_cast<double>(random()); }

Vec3 random_direction(Random& random) {
  const double z = uniform(random, -1.0, 1.0);
  const double angle = uniform(random, 0.0, 6.283185307179586);
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// A sphere whose vertices are displaced by up to its radius.
TriangleMesh make_crossing_itself(Random& random) {
  TriangleMesh mesh = make_icosphere(1.0, 2);
  const double most = uniform(random, 0.2, 0.9);
  for (Vec3& vertex : mesh.vertices) vertex += most * uniform(random, 0.0, 1.0) * random_direction(random);
  return mesh;
}

// A bumpy sphere. One triangle after another, mostly one of those just made, is split in three at a point off its plane.
TriangleMesh make_graded(Random& random) {
  constexpr int kSplits = 40;
  TriangleMesh mesh = make_icosphere(1.0, 1);
  for (Vec3& vertex : mesh.vertices) vertex *= 1.0 + uniform(random, -0.3, 0.3);
  std::size_t split = random() % mesh.triangles.size();
  for (int i = 0; i < kSplits; ++i) {
    const Triangle whole = mesh.triangles[split];
    const Vec3& a = mesh.vertices[whole[0]];
    const Vec3 ab = mesh.vertices[whole[1]] - a;
    const Vec3 ac = mesh.vertices[whole[2]] - a;
    const double along_ab = uniform(random, 0.2, 0.5);
    const double along_ac = uniform(random, 0.2, 0.4);
    const Vec3 middle = a + along_ab * ab + along_ac * ac + ab.norm() * uniform(random, -0.3, 0.3) * ab.cross(ac).normalized();
    const auto added = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    mesh.triangles[split] = {whole[0], whole[1], added};
    mesh.triangles.push_back({whole[1], whole[2], added});
    mesh.triangles.push_back({whole[2], whole[0], added});
    if (random() % 3 == 0) split = mesh.triangles.size() - 1 - random() % 2;
  }
  return mesh;
}

// A bumpy sphere with copies of its faces, or of half of them, each displaced by 1e-14 to 1e-6 of its radius.
TriangleMesh make_copied(Random& random) {
  TriangleMesh mesh = make_icosphere(1.0, 2);
  for (Vec3& vertex : mesh.vertices) vertex *= 1.0 + uniform(random, -0.2, 0.2);
  const double displaced = std::pow(10.0, uniform(random, -14.0, -6.0));
  const std::size_t count = mesh.triangles.size();
  const bool copies_all = random() % 2 != 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!copies_all && random() % 2 != 0) continue;
    Triangle copy{};
    for (std::size_t k = 0; k < 3; ++k) {
      copy[k] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(mesh.vertices[mesh.triangles[i][k]] + displaced * random_direction(random));
    }
    mesh.triangles.push_back(copy);
  }
  return mesh;
}

// Closed wedges of 1e-7 to 1e-1 rad that meet in one line or in one point, and cross each other.
TriangleMesh make_blades(Random& random) {
  TriangleMesh mesh;
  const std::size_t count = 2 + random() % 6;
  const bool is_about_line = random() % 2 != 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double opening = std::pow(10.0, uniform(random, -7.0, -1.0));
    const double length = uniform(random, 0.3, 0.7);
    const Vec3 far = length * Vec3(std::cos(opening), std::sin(opening), 0.0);
    const Vec3 half = 0.5 * Vec3::UnitZ();
    TriangleMesh blade;
    blade.vertices = {-half, half, length * Vec3::UnitX() - half, length * Vec3::UnitX() + half, far - half, far + half};
    blade.triangles = {{0, 3, 1}, {0, 2, 3}, {0, 1, 5}, {0, 5, 4}, {0, 4, 2}, {1, 3, 5}, {2, 4, 5}, {2, 5, 3}};
    if (compute_volume(blade) < 0.0) blade = flipped(std::move(blade));
    const Vec3 axis = is_about_line ? Vec3(Vec3::UnitZ()) : random_direction(random);
    const Mat3 turn = Eigen::AngleAxisd(uniform(random, 0.0, 6.28), axis).toRotationMatrix();
    for (Vec3& vertex : blade.vertices) vertex = turn * vertex;
    mesh = joined(mesh, blade);
  }
  return mesh;
}

// The surface where a function on a grid is zero, by marching tetrahedra. The function is positive inside, and negative on the rim.
class MarchedSurface {
 public:
  MarchedSurface(int cells, std::vector<double> values) : cells_(cells), values_(std::move(values)) {
    constexpr std::array<std::array<int, 3>, 6> kOrders = {{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        for (int k = 0; k < cells; ++k) {
          for (const auto& order : kOrders) cut_tetrahedron({i, j, k}, order);
        }
      }
    }
  }

  static std::size_t number(int cells, int i, int j, int k) { return static_cast<std::size_t>((i * (cells + 1) + j) * (cells + 1) + k); }
  TriangleMesh mesh;

 private:
  Vec3 place(std::size_t id) const {
    const auto side = static_cast<std::size_t>(cells_) + 1;
    const Vec3 p(static_cast<double>(id / side / side), static_cast<double>(id / side % side), static_cast<double>(id % side));
    return p * (2.0 / cells_) - Vec3::Ones();
  }
  std::uint32_t cut_edge(std::size_t a, std::size_t b) {
    if (a > b) std::swap(a, b);
    const auto [it, is_new] = cuts_.try_emplace({a, b}, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(place(a) + values_[a] / (values_[a] - values_[b]) * (place(b) - place(a)));
    return it->second;
  }
  Vec3 mean(const std::vector<std::size_t>& ids) const {
    Vec3 sum = Vec3::Zero();
    for (const std::size_t id : ids) sum += place(id);
    return sum / static_cast<double>(ids.size());
  }
  void cut_tetrahedron(std::array<int, 3> p, const std::array<int, 3>& order) {
    std::vector<std::size_t> in, out;
    for (std::size_t step = 0; step < 4; ++step) {
      if (step > 0) ++p[static_cast<std::size_t>(order[step - 1])];
      const std::size_t id = number(cells_, p[0], p[1], p[2]);
      (values_[id] > 0.0 ? in : out).push_back(id);
    }
    if (in.empty() || out.empty()) return;
    std::vector<std::pair<std::size_t, std::size_t>> edges;
    if (in.size() == 2) {
      edges = {{in[0], out[0]}, {in[0], out[1]}, {in[1], out[1]}, {in[1], out[0]}};
    } else {
      for (const std::size_t a : in) {
        for (const std::size_t b : out) edges.emplace_back(a, b);
      }
    }
    std::vector<std::uint32_t> corners;
    std::array<Vec3, 4> middle;
    for (const auto& [a, b] : edges) {
      middle[corners.size()] = 0.5 * (place(a) + place(b));
      corners.push_back(cut_edge(a, b));
    }
    if ((middle[1] - middle[0]).cross(middle[2] - middle[0]).dot(mean(out) - mean(in)) < 0.0) std::reverse(corners.begin(), corners.end());
    for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  }

  int cells_;
  std::vector<double> values_;
  std::map<std::pair<std::size_t, std::size_t>, std::uint32_t> cuts_;
};

// A gyroid whose function is nearly zero at a third of the grid: there the triangles are needles, down to a billionth of the extent.
TriangleMesh make_gyroid(Random& random) {
  const int cells = 8 + 4 * static_cast<int>(random() % 3);
  const double radians_per_unit = 3.14159265358979 * (2.0 + static_cast<double>(random() % 3));
  const double level = uniform(random, -0.3, 0.7);
  const double shift = random() % 2 != 0 ? uniform(random, 0.0, 1.0) : 0.0;
  std::vector<double> values(MarchedSurface::number(cells, cells, cells, cells) + 1);
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      for (int k = 0; k <= cells; ++k) {
        const Vec3 p = radians_per_unit * (0.5 * (Vec3(i, j, k) * (2.0 / cells)) + Vec3(shift, 0.0, 0.0));
        double v = level - (std::sin(p.x()) * std::cos(p.y()) + std::sin(p.y()) * std::cos(p.z()) + std::sin(p.z()) * std::cos(p.x()));
        if (random() % 10 < 3) v = std::copysign(std::pow(10.0, uniform(random, -12.0, -3.0)), v);
        const bool is_rim = std::min({i, j, k}) == 0 || std::max({i, j, k}) == cells;
        values[MarchedSurface::number(cells, i, j, k)] = is_rim ? -std::fabs(v) - 0.01 : v;
      }
    }
  }
  return MarchedSurface(cells, std::move(values)).mesh;
}

struct MadeBody {
  const char* name;
  TriangleMesh (*make)(Random&);
  std::uint64_t seed;
  std::uint64_t episode;
  double probe_share = 0.0;
};

class StressOnMadeBodies : public ::testing::TestWithParam<MadeBody> {};

TEST_P(StressOnMadeBodies, HasNoFault) {
  const MadeBody& made = GetParam();
  Random random(made.seed);
  TriangleMesh mesh = made.make(random);
  const double extent = compute_bounds(mesh).extent();
  for (Vec3& vertex : mesh.vertices) vertex *= 0.1 / extent;
  StressSettings settings;
  settings.seed = made.seed;
  settings.compare_every = 16;
  StressBody body = make_stress_body(made.name, std::move(mesh));
  body.probe_share = made.probe_share;
  auto run = StressRun::make(body, settings, {.name = "proxy"});
  ASSERT_TRUE(run) << run.error().what;
  StressCount count;
  EXPECT_GT(run->run_episode(made.episode, count), 0U);
  for (std::size_t fault = 0; fault < count.faults.size(); ++fault) {
    EXPECT_EQ(count.faults[fault], 0U) << name_of(static_cast<StressFault>(fault));
  }
}

std::string name_of_episode(const testing::TestParamInfo<MadeBody>& test) {
  const std::string body = std::string(test.param.name) + "_" + std::to_string(test.param.seed);
  return body + "_" + std::to_string(test.param.episode) + (test.param.probe_share == 0.001 ? "_small" : "");
}

// The faults found: a sphere that passed a corner skipped a wall that begins there. Or the way out of a corner led beyond the other side of
// a slit, or was not found because no edge of the corner leads nearer to the device. Or a point that left a face in a narrow wedge was
// lifted through the other face.
INSTANTIATE_TEST_SUITE_P(
    Found, StressOnMadeBodies,
    testing::Values(MadeBody{"crossing", make_crossing_itself, 239, 3}, MadeBody{"crossing", make_crossing_itself, 265, 1},
                    MadeBody{"crossing", make_crossing_itself, 809, 7}, MadeBody{"crossing", make_crossing_itself, 869, 4},
                    MadeBody{"crossing", make_crossing_itself, 875, 6}, MadeBody{"crossing", make_crossing_itself, 950, 6},
                    MadeBody{"crossing", make_crossing_itself, 1077, 6}, MadeBody{"crossing", make_crossing_itself, 1294, 3},
                    MadeBody{"graded", make_graded, 680, 4}, MadeBody{"graded", make_graded, 829, 1},
                    MadeBody{"graded", make_graded, 829, 7}, MadeBody{"graded", make_graded, 1226, 5},
                    MadeBody{"graded", make_graded, 1619, 6}),
    name_of_episode);

// A narrow corner held the sphere that stands for a point so far from the corner's vertex that no corner was recognised. Or the way out of
// the corner led into a slit that has room for the sphere only farther out than was tried.
INSTANTIATE_TEST_SUITE_P(FarFromTheCorner, StressOnMadeBodies,
                         testing::Values(MadeBody{"crossing", make_crossing_itself, 1604, 0},
                                         MadeBody{"crossing", make_crossing_itself, 1604, 1},
                                         MadeBody{"crossing", make_crossing_itself, 1616, 5}, MadeBody{"graded", make_graded, 123, 7},
                                         MadeBody{"graded", make_graded, 398, 0}, MadeBody{"graded", make_graded, 610, 4},
                                         MadeBody{"graded", make_graded, 828, 6}, MadeBody{"graded", make_graded, 1136, 5},
                                         MadeBody{"graded", make_graded, 1168, 2}),
                         name_of_episode);

// A sphere that rolled over an edge, beside a displaced copy of that edge, was carried from step to step and had not arrived after 1,024
// steps. Or it was held on the face of a needle between an edge and its copy, although it had already passed that face.
INSTANTIATE_TEST_SUITE_P(BesideCopies, StressOnMadeBodies,
                         testing::Values(MadeBody{"dup", make_copied, 5, 4, 0.005}, MadeBody{"dup", make_copied, 11, 7, 0.005},
                                         MadeBody{"dup", make_copied, 19, 3, 0.005}, MadeBody{"dup", make_copied, 32, 0, 0.005},
                                         MadeBody{"dup", make_copied, 35, 5, 0.005}, MadeBody{"dup", make_copied, 126, 2, 0.005},
                                         MadeBody{"dup", make_copied, 126, 2, 0.001}),
                         name_of_episode);

// The sphere was over the border of a face, at a convex edge, with the device straight below: a minimum of the face, but not of the edge.
INSTANTIATE_TEST_SUITE_P(OverABoundary, StressOnMadeBodies,
                         testing::Values(MadeBody{"crossing", make_crossing_itself, 195, 1, 0.001},
                                         MadeBody{"crossing", make_crossing_itself, 262, 2, 0.001}),
                         name_of_episode);

// Faces and an edge of bodies that cross held the sphere that stands for a point, and no corner was recognised because they have no vertex
// in common. Or the way out was blocked by a displaced copy of the face along which it leads.
INSTANTIATE_TEST_SUITE_P(WhereBodiesCross, StressOnMadeBodies,
                         testing::Values(MadeBody{"blades", make_blades, 17, 3}, MadeBody{"blades", make_blades, 25, 7},
                                         MadeBody{"blades", make_blades, 88, 5}, MadeBody{"blades", make_blades, 106, 4},
                                         MadeBody{"blades", make_blades, 147, 3}, MadeBody{"blades", make_blades, 148, 0},
                                         MadeBody{"blades", make_blades, 148, 4}, MadeBody{"dup", make_copied, 104, 3}),
                         name_of_episode);

// Among triangles smaller than the sphere that stands for a point, the way out of a corner ended on the other side: the point fell through.
INSTANTIATE_TEST_SUITE_P(AmongNeedles, StressOnMadeBodies,
                         testing::Values(MadeBody{"gy", make_gyroid, 21, 7}, MadeBody{"gy", make_gyroid, 22, 4},
                                         MadeBody{"gy", make_gyroid, 29, 6}, MadeBody{"gy", make_gyroid, 33, 4},
                                         MadeBody{"gy", make_gyroid, 43, 5}, MadeBody{"gy", make_gyroid, 50, 7},
                                         MadeBody{"gy", make_gyroid, 61, 5}),
                         name_of_episode);

}  // namespace
}  // namespace hapton
