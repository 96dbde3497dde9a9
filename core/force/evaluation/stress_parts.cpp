#include "core/force/evaluation/stress_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kExtent = 0.1;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  double power(double low, double high) { return std::pow(10.0, uniform(low, high)); }  // 10^low to 10^high
  int below(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  Mat3 rotation() {
    std::normal_distribution<double> normal;
    return Quat(normal(engine_), normal(engine_), normal(engine_), normal(engine_)).normalized().toRotationMatrix();
  }

 private:
  std::mt19937_64 engine_;
};

struct Block {
  Vec3 low;
  Vec3 high;
  bool holds(const Vec3& p) const { return (p.array() > low.array()).all() && (p.array() < high.array()).all(); }
};

TriangleMesh moved(const TriangleMesh& mesh, const Vec3& by) { return scaled_and_moved(mesh, 1.0, by); }

TriangleMesh posed(TriangleMesh mesh, const Mat3& rotation, const Vec3& offset) {
  for (Vec3& vertex : mesh.vertices) vertex = rotation * vertex + offset;
  return mesh;
}

void append(TriangleMesh& all, const TriangleMesh& part) { all = joined(all, part); }

// What is cut out of the block: slots from above, all along y, undercuts from the sides, pockets from above; 0.1 % to 3 % wide.
std::vector<Block> draw_cuts(const Block& block, Random& random) {
  const Vec3 size = block.high - block.low;
  const Vec3 beyond = 0.1 * size;
  const auto width = [&] { return kExtent * random.power(-3.0, -1.5); };
  std::vector<Block> cuts;
  for (int i = 0; i < 3; ++i) {
    const double x = block.low.x() + size.x() * (0.2 + 0.3 * i + random.uniform(-0.08, 0.08));
    const double floor = block.low.z() + size.z() * random.uniform(0.1, 0.6);
    cuts.push_back({{x, block.low.y() - beyond.y(), floor}, {x + width(), block.high.y() + beyond.y(), block.high.z() + beyond.z()}});
  }
  for (int side = 0; side < 2; ++side) {
    const double z = block.low.z() + size.z() * random.uniform(0.2, 0.7);
    const double depth = size.y() * random.uniform(0.2, 0.4);
    Block cut{{block.low.x() - beyond.x(), block.low.y() - beyond.y(), z},
              {block.high.x() + beyond.x(), block.low.y() + depth, z + width()}};
    if (side == 1) {
      cut.low.y() = block.high.y() - depth;
      cut.high.y() = block.high.y() + beyond.y();
    }
    cuts.push_back(cut);
  }
  for (int i = 0; i < 3; ++i) {
    const Vec3 at = block.low + size.cwiseProduct(Vec3(0.05 + 0.3 * i + random.uniform(0.0, 0.1), random.uniform(0.1, 0.7), 0.0));
    const double floor = block.low.z() + size.z() * random.uniform(0.3, 0.9);
    cuts.push_back({{at.x(), at.y(), floor}, {at.x() + width(), at.y() + 4.0 * width(), block.high.z() + beyond.z()}});
  }
  return cuts;
}

// The grid lines that contain all faces, and some between them.
std::vector<double> lines_of(const std::vector<Block>& blocks, const Block& block, int axis, int divisions) {
  std::vector<double> lines;
  for (const Block& each : blocks) {
    lines.push_back(each.low[axis]);
    lines.push_back(each.high[axis]);
  }
  for (int i = 0; i <= divisions; ++i) {
    lines.push_back(i == divisions ? block.high[axis] : block.low[axis] + (block.high[axis] - block.low[axis]) * i / divisions);
  }
  std::erase_if(lines, [&](double x) { return x < block.low[axis] || x > block.high[axis]; });
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  return lines;
}

// The outer surface of the front over u, v in 0..1: a hood that slopes to the sides, with a crease.
Vec3 front_surface(double u, double v, double offset) {
  const double across = 2.0 * u - 1.0;
  const double along = 2.0 * v - 1.0;
  const double crease = 0.002 * std::fabs(along - 0.2 * across);
  const double height = 0.035 * (1.0 - 0.6 * across * across) * (1.0 - 0.5 * along * along * along * along) - crease;
  return {kExtent * (u - 0.5), 0.6 * kExtent * (v - 0.5), height + offset};
}

struct Panel {
  std::array<double, 2> u;
  std::array<double, 2> v;
};

// flipped_share: probability that a triangle is flipped.
TriangleMesh make_panel(const Panel& panel, int cells, double offset, double flipped_share, Random& random) {
  TriangleMesh mesh;
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      const double u = panel.u[0] + (panel.u[1] - panel.u[0]) * i / cells;
      const double v = panel.v[0] + (panel.v[1] - panel.v[0]) * j / cells;
      mesh.vertices.push_back(front_surface(u, v, offset));
    }
  }
  const auto add = [&](int a, int b, int c) {
    Triangle t = {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)};
    if (random.uniform(0.0, 1.0) < flipped_share) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  };
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const int at = i * (cells + 1) + j;
      add(at, at + cells + 1, at + cells + 2);
      add(at, at + cells + 2, at + 1);
    }
  }
  return mesh;
}

}  // namespace

TriangleMesh make_star() {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 10; ++i) {
    const double radius = (i % 2 == 0 ? 0.5 : 0.12) * kExtent;
    const double angle = std::numbers::pi * i / 5.0;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return make_prism(outline, 0.4 * kExtent, 3);
}

TriangleMesh make_cell_solid(const std::vector<double>& x_m, const std::vector<double>& y_m, const std::vector<double>& z_m,
                             const std::function<bool(int, int, int)>& is_solid) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> number;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] = number.try_emplace(at, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.emplace_back(x_m[at[0]], y_m[at[1]], z_m[at[2]]);
    return entry->second;
  };
  const std::array<int, 3> cells = {static_cast<int>(x_m.size()) - 1, static_cast<int>(y_m.size()) - 1, static_cast<int>(z_m.size()) - 1};
  const auto holds = [&](std::array<int, 3> cell) {
    for (int k = 0; k < 3; ++k) {
      if (cell[k] < 0 || cell[k] >= cells[k]) return false;
    }
    return is_solid(cell[0], cell[1], cell[2]);
  };
  // Adds the face of a cell on its lower or upper side along an axis.
  const auto add_face = [&](const std::array<int, 3>& cell, int axis, int upper) {
    std::array<int, 3> corner = cell;
    corner[axis] += upper;
    std::array<std::uint32_t, 4> ring;
    for (int i = 0; i < 4; ++i) {
      std::array<int, 3> at = corner;
      at[(axis + 1) % 3] += i == 1 || i == 2 ? 1 : 0;
      at[(axis + 2) % 3] += i >= 2 ? 1 : 0;
      ring[i] = vertex(at);
    }
    if (upper == 0) std::swap(ring[1], ring[3]);
    mesh.triangles.push_back({ring[0], ring[1], ring[2]});
    mesh.triangles.push_back({ring[0], ring[2], ring[3]});
  };
  std::array<int, 3> cell;
  for (cell[0] = 0; cell[0] < cells[0]; ++cell[0]) {
    for (cell[1] = 0; cell[1] < cells[1]; ++cell[1]) {
      for (cell[2] = 0; cell[2] < cells[2]; ++cell[2]) {
        if (!holds(cell)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (const int upper : {0, 1}) {
            std::array<int, 3> next = cell;
            next[axis] += 2 * upper - 1;
            if (!holds(next)) add_face(cell, axis, upper);
          }
        }
      }
    }
  }
  return mesh;
}

TriangleMesh make_slotted_part(std::uint64_t seed, double bend_radius_m) {
  Random random(seed);
  const Vec3 half = 0.5 * kExtent * Vec3(1.0, 0.6, 0.3);
  const Block block{-half, half};
  const std::vector<Block> cuts = draw_cuts(block, random);
  const std::array<std::vector<double>, 3> lines = {lines_of(cuts, block, 0, bend_radius_m > 0.0 ? 24 : 3), lines_of(cuts, block, 1, 2),
                                                    lines_of(cuts, block, 2, 1)};
  const auto middle = [&](int axis, int i) { return 0.5 * (lines[axis][i] + lines[axis][i + 1]); };
  TriangleMesh mesh = make_cell_solid(lines[0], lines[1], lines[2], [&](int i, int j, int k) {
    const Vec3 p(middle(0, i), middle(1, j), middle(2, k));
    return std::none_of(cuts.begin(), cuts.end(), [&](const Block& cut) { return cut.holds(p); });
  });
  if (bend_radius_m > 0.0) {
    for (Vec3& p : mesh.vertices) {
      const double radius = bend_radius_m + p.z();
      const double angle = p.x() / bend_radius_m;
      p = {radius * std::sin(angle), p.y(), radius * std::cos(angle) - bend_radius_m};
    }
  }
  return posed(std::move(mesh), random.rotation(), Vec3::Zero());
}

TriangleMesh make_open_front(std::uint64_t seed) {
  Random random(seed);
  constexpr int kAcross = 4;
  constexpr int kAlong = 3;
  TriangleMesh all;
  for (int i = 0; i < kAcross; ++i) {
    for (int j = 0; j < kAlong; ++j) {
      const double gap = random.power(-3.5, -2.0);
      const Panel panel{{(i + gap) / kAcross, (i + 1 - gap) / kAcross}, {(j + gap) / kAlong, (j + 1 - gap) / kAlong}};
      const int kind = i == 0 && j == 0 ? 1 : random.below(4);
      const double flipped_share = kind == 0 ? 1.0 : kind == 1 ? 0.2 : 0.0;
      const TriangleMesh panel_mesh = make_panel(panel, 3 + random.below(6), 0.0, flipped_share, random);
      append(all, panel_mesh);
      if (random.below(2) == 0) append(all, make_panel(panel, 1 + random.below(3), -kExtent * random.power(-3.5, -2.0), 0.0, random));
      if (i == 1 && j == 1) append(all, flipped(panel_mesh));
    }
  }
  for (int i = 0; i < 3; ++i) {  // ribs: open sheets through the outer surface
    const double u = random.uniform(0.1, 0.9);
    const Vec3 from = front_surface(u, 0.1, random.uniform(-0.001, 0.001));
    const Vec3 to = front_surface(u + random.uniform(-0.1, 0.1), 0.9, random.uniform(-0.001, 0.001));
    const Vec3 down(0.0, 0.0, -0.02);
    append(all, {.vertices = {from, to, to + down, from + down}, .triangles = {{0, 1, 2}, {0, 2, 3}}});
  }
  for (const double u : {0.15, 0.85}) append(all, moved(make_icosphere(0.006, 2), front_surface(u, 0.2, random.uniform(-0.006, 0.002))));
  return all;
}

TriangleMesh make_touching_parts() {
  constexpr double kSide = 0x1p-5;  // m: a power of two, so sums of it are exact
  TriangleMesh all;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) {
      append(all, moved(make_box(Vec3(kSide, kSide, 0.5 * kSide), 1 + (i + 2 * j) % 3), Vec3((i - 1) * kSide, (j - 0.5) * kSide, 0.0)));
    }
  }
  append(all, moved(make_cylinder(0.4 * kSide, kSide, 24, 2), Vec3(-kSide, 0.0, 0.75 * kSide)));
  // A hollow box whose floor lies on the boxes below.
  const Vec3 offset(kSide, 0.0, 0.75 * kSide);
  append(all, moved(make_box(Vec3(kSide, kSide, kSide), 2), offset));
  append(all, moved(flipped(make_box(Vec3::Constant(0.75 * kSide), 3)), offset));
  append(all, moved(make_box(Vec3(0.0625 * kSide, 0.75 * kSide, 0.5 * kSide), 1), offset + Vec3((0.375 - 0.03125) * kSide, 0.0, 0.0)));
  return all;
}

TriangleMesh make_overlapping_parts(std::uint64_t seed) {
  Random random(seed);
  TriangleMesh all;
  for (int i = 0; i < 8; ++i) {
    const double size = random.uniform(0.02, 0.05);
    const auto make = [&]() -> TriangleMesh {
      switch (i % 4) {
        case 0:
          return make_box(size * Vec3(1.0, random.uniform(0.1, 1.0), random.uniform(0.1, 1.0)), 1 + random.below(3));
        case 1:
          return make_cylinder(0.4 * size, size, 6 + random.below(30), 2);
        case 2:
          return make_icosphere(0.5 * size, 2);
        default:
          return make_torus(0.4 * size, 0.12 * size, 20, 10);
      }
    };
    const Vec3 offset(random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02));
    const TriangleMesh part = posed(make(), random.rotation(), offset);
    append(all, part);
    if (i == 0) append(all, part);
    if (i == 1) append(all, moved(part, Vec3(1.0, 1.0, -1.0) * kExtent * random.power(-10.0, -5.0)));
  }
  return all;
}

}  // namespace hapton
