#include "core/geometry/mesh_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <unordered_map>
#include <utility>

namespace hapton {
namespace {

using Index = std::uint32_t;

TriangleMesh make_icosahedron() {
  const double g = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Vec3& vertex : mesh.vertices) vertex.normalize();
  return mesh;
}

void subdivide_on_unit_sphere(TriangleMesh& mesh) {
  std::unordered_map<std::uint64_t, Index> midpoints;
  midpoints.reserve(mesh.triangles.size() * 2);
  auto midpoint = [&](Index a, Index b) {
    const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    const auto [at, is_new] = midpoints.try_emplace(key, static_cast<Index>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
    return at->second;
  };
  std::vector<Triangle> finer;
  finer.reserve(mesh.triangles.size() * 4);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Index ab = midpoint(a, b);
    const Index bc = midpoint(b, c);
    const Index ca = midpoint(c, a);
    finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(finer);
}

void add_quad(TriangleMesh& mesh, Index a, Index b, Index c, Index d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

double cross_2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool is_inside_or_on(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& p) {
  return cross_2d(a, b, p) >= 0.0 && cross_2d(b, c, p) >= 0.0 && cross_2d(c, a, p) >= 0.0;
}

bool is_ear(const std::vector<Eigen::Vector2d>& outline, const std::vector<Index>& remaining, std::size_t i) {
  const std::size_t n = remaining.size();
  const Index before = remaining[(i + n - 1) % n];
  const Index at = remaining[i];
  const Index after = remaining[(i + 1) % n];
  if (cross_2d(outline[before], outline[at], outline[after]) <= 0.0) return false;
  return std::none_of(remaining.begin(), remaining.end(), [&](Index other) {
    return other != before && other != at && other != after &&
           is_inside_or_on(outline[before], outline[at], outline[after], outline[other]);
  });
}

std::vector<Triangle> clip_ears(const std::vector<Eigen::Vector2d>& outline) {
  std::vector<Index> remaining(outline.size());
  for (Index i = 0; i < remaining.size(); ++i) remaining[i] = i;
  std::vector<Triangle> triangles;
  while (remaining.size() > 3) {
    std::size_t ear = 0;
    while (ear < remaining.size() && !is_ear(outline, remaining, ear)) ++ear;
    if (ear == remaining.size()) ear = 0;  // only for outlines that are not simple: keeps the number of triangles right
    const std::size_t n = remaining.size();
    triangles.push_back({remaining[(ear + n - 1) % n], remaining[ear], remaining[(ear + 1) % n]});
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({remaining[0], remaining[1], remaining[2]});
  return triangles;
}

}  // namespace

TriangleMesh make_icosphere(double radius_m, int level) {
  TriangleMesh mesh = make_icosahedron();
  for (int i = 0; i < level; ++i) subdivide_on_unit_sphere(mesh);
  for (Vec3& vertex : mesh.vertices) vertex *= radius_m;
  return mesh;
}

TriangleMesh make_box(const Vec3& size_m, int cells) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, Index> welded;
  auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = welded.try_emplace(at, static_cast<Index>(mesh.vertices.size()));
    if (is_new)
      mesh.vertices.push_back(
          Vec3(at[0] / double(cells) - 0.5, at[1] / double(cells) - 0.5, at[2] / double(cells) - 0.5).cwiseProduct(size_m));
    return found->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
          auto at = [&](int du, int dv) {
            std::array<int, 3> cell{};
            cell[axis] = side * cells;
            cell[u] = i + du;
            cell[v] = j + dv;
            return vertex(cell);
          };
          if (side == 1) {
            add_quad(mesh, at(0, 0), at(1, 0), at(1, 1), at(0, 1));
          } else {
            add_quad(mesh, at(0, 0), at(0, 1), at(1, 1), at(1, 0));
          }
        }
      }
    }
  }
  return mesh;
}

TriangleMesh make_cylinder(double radius_m, double height_m, int sides, int layers) {
  TriangleMesh mesh;
  for (int j = 0; j <= layers; ++j) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / sides;
      mesh.vertices.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), height_m * (double(j) / layers - 0.5));
    }
  }
  const auto bottom = static_cast<Index>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.0, 0.0, -0.5 * height_m);
  mesh.vertices.emplace_back(0.0, 0.0, 0.5 * height_m);
  auto at = [&](int i, int j) { return static_cast<Index>(j * sides + i % sides); };
  for (int i = 0; i < sides; ++i) {
    for (int j = 0; j < layers; ++j) add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    mesh.triangles.push_back({bottom, at(i + 1, 0), at(i, 0)});
    mesh.triangles.push_back({bottom + 1, at(i, layers), at(i + 1, layers)});
  }
  return mesh;
}

TriangleMesh make_torus(double ring_radius_m, double tube_radius_m, int around_axis, int around_tube) {
  TriangleMesh mesh;
  for (int i = 0; i < around_axis; ++i) {
    const double u = 2.0 * std::numbers::pi * i / around_axis;
    for (int j = 0; j < around_tube; ++j) {
      const double v = 2.0 * std::numbers::pi * j / around_tube;
      const double ring = ring_radius_m + tube_radius_m * std::cos(v);
      mesh.vertices.emplace_back(ring * std::cos(u), ring * std::sin(u), tube_radius_m * std::sin(v));
    }
  }
  auto at = [&](int i, int j) { return static_cast<Index>((i % around_axis) * around_tube + j % around_tube); };
  for (int i = 0; i < around_axis; ++i) {
    for (int j = 0; j < around_tube; ++j) add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return mesh;
}

TriangleMesh make_plane_grid(double side_m, int cells) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i)
      mesh.vertices.emplace_back(side_m * (double(i) / cells - 0.5), side_m * (double(j) / cells - 0.5), 0.0);
  }
  auto at = [&](int i, int j) { return static_cast<Index>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return mesh;
}

TriangleMesh make_bumpy_sphere(double radius_m, double relative_height, std::size_t min_triangles, std::uint64_t seed) {
  int level = 0;
  for (std::size_t count = 20; count < min_triangles; count *= 4) ++level;
  TriangleMesh mesh = make_icosphere(1.0, level);
  struct Wave {
    Vec3 vector;
    double phase;
    double height;
  };
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  std::vector<Wave> waves;
  for (int octave = 0; octave < 3; ++octave) {
    for (int i = 0; i < 4; ++i) {
      Vec3 direction(symmetric(random), symmetric(random), symmetric(random));
      while (direction.squaredNorm() < 0.01) direction = Vec3(symmetric(random), symmetric(random), symmetric(random));
      const double wave_number = 4.0 * std::pow(2.2, octave);
      waves.push_back({wave_number * direction.normalized(), std::numbers::pi * symmetric(random), 0.25 / wave_number * 4.0 / 1.6});
    }
  }
  for (Vec3& vertex : mesh.vertices) {
    double bump = 0.0;
    for (const Wave& wave : waves) bump += wave.height * std::sin(wave.vector.dot(vertex) + wave.phase);
    vertex *= radius_m * (1.0 + relative_height * bump);
  }
  return mesh;
}

TriangleMesh make_rough_sphere(double radius_m, double curvature_radius_m, double wavelength_m, std::size_t min_triangles,
                               std::uint64_t seed) {
  constexpr int kWaves = 8;
  int level = 0;
  for (std::size_t count = 20; count < min_triangles; count *= 4) ++level;
  TriangleMesh mesh = make_icosphere(radius_m, level);
  const double wave_number = 2.0 * std::numbers::pi / wavelength_m;
  const double height = std::sqrt(10.0 / kWaves) / (curvature_radius_m * wave_number * wave_number);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  std::array<Vec3, kWaves> wave_vector;
  std::array<double, kWaves> phase_shift{};
  for (int i = 0; i < kWaves; ++i) {
    const double x = normal(random), y = normal(random), z = normal(random);
    wave_vector[i] = wave_number * Vec3(x, y, z).normalized();
    phase_shift[i] = phase(random);
  }
  for (Vec3& vertex : mesh.vertices) {
    double bump = 0.0;
    for (int i = 0; i < kWaves; ++i) bump += height * std::sin(wave_vector[i].dot(vertex) + phase_shift[i]);
    vertex *= 1.0 + bump / radius_m;
  }
  return mesh;
}

TriangleMesh make_thin_wall(double side_m, double thickness_m, int cells) { return make_box(Vec3(side_m, side_m, thickness_m), cells); }

TriangleMesh make_prism(const std::vector<Eigen::Vector2d>& outline_m, double length_m, int layers) {
  TriangleMesh mesh;
  const auto n = static_cast<Index>(outline_m.size());
  for (int j = 0; j <= layers; ++j) {
    for (const Eigen::Vector2d& corner : outline_m)
      mesh.vertices.emplace_back(corner.x(), corner.y(), length_m * (double(j) / layers - 0.5));
  }
  for (Index j = 0; j < static_cast<Index>(layers); ++j) {
    for (Index i = 0; i < n; ++i) {
      const Index next = (i + 1) % n;
      add_quad(mesh, j * n + i, j * n + next, (j + 1) * n + next, (j + 1) * n + i);
    }
  }
  const Index top = static_cast<Index>(layers) * n;
  for (const auto& [a, b, c] : clip_ears(outline_m)) {
    mesh.triangles.push_back({c, b, a});
    mesh.triangles.push_back({top + a, top + b, top + c});
  }
  return mesh;
}

TriangleMesh make_gutter(double side_m, double depth_m, double opening_rad, int layers) {
  const double h = 0.5 * side_m;
  const double half_width = std::min(depth_m * std::tan(0.5 * opening_rad), 0.9 * h);
  return make_prism({{-h, -h}, {h, -h}, {h, h}, {half_width, h}, {0.0, h - depth_m}, {-half_width, h}, {-h, h}}, side_m, layers);
}

TriangleMesh make_staircase(double side_m, int steps, int layers) {
  const double h = 0.5 * side_m;
  std::vector<Eigen::Vector2d> outline{{-h, -h}, {h, -h}};
  for (int i = steps; i > 0; --i) {
    const double top = -h + side_m * i / steps;
    outline.emplace_back(-h + side_m * i / steps, top);
    outline.emplace_back(-h + side_m * (i - 1) / steps, top);
  }
  // The last corner is above the first; the outline closes down the lowest riser.
  return make_prism(outline, side_m, layers);
}

TriangleMesh make_pit(double side_m, double depth_m) {
  const double h = 0.5 * side_m;
  const double r = 0.8 * h;
  TriangleMesh mesh;
  for (double z : {-h, h}) {
    for (const auto& [x, y] : {std::pair{-h, -h}, {h, -h}, {h, h}, {-h, h}}) mesh.vertices.emplace_back(x, y, z);
  }
  for (const auto& [x, y] : {std::pair{-r, -r}, {r, -r}, {r, r}, {-r, r}}) mesh.vertices.emplace_back(x, y, h);
  mesh.vertices.emplace_back(0.0, 0.0, h - depth_m);
  add_quad(mesh, 3, 2, 1, 0);
  for (Index i = 0; i < 4; ++i) {
    const Index next = (i + 1) % 4;
    add_quad(mesh, i, next, 4 + next, 4 + i);
    add_quad(mesh, 4 + i, 4 + next, 8 + next, 8 + i);
    mesh.triangles.push_back({8 + i, 8 + next, 12});
  }
  return mesh;
}

TriangleMesh flipped(TriangleMesh mesh) {
  for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  for (auto& normals : mesh.authored_normals) normals = {-normals[0], -normals[2], -normals[1]};
  return mesh;
}

TriangleMesh scaled_and_moved(TriangleMesh mesh, double scale, const Vec3& move_m) {
  for (Vec3& vertex : mesh.vertices) vertex = vertex * scale + move_m;
  return mesh;
}

TriangleMesh joined(const TriangleMesh& first, const TriangleMesh& second) {
  TriangleMesh mesh = first;
  const auto shift = static_cast<Index>(first.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (const auto& [a, b, c] : second.triangles) mesh.triangles.push_back({a + shift, b + shift, c + shift});
  if (first.has_authored_normals() || second.has_authored_normals()) {
    const std::array<Eigen::Vector3f, 3> kNone = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    mesh.authored_normals.resize(first.triangles.size(), kNone);
    mesh.authored_normals.insert(mesh.authored_normals.end(), second.authored_normals.begin(), second.authored_normals.end());
    mesh.authored_normals.resize(mesh.triangles.size(), kNone);
  }
  return mesh;
}

}  // namespace hapton
