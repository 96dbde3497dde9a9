#include "core/geometry/corner_normals.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "core/geometry/disjoint_sets.h"
#include "core/geometry/key_table.h"
#include "core/geometry/shared_edges.h"

namespace hapton {
namespace {

constexpr double kMinNormalCosine = 0.0872;  // cosine of 85 degrees

template <class Mesh>
Vec3 unit_face_normal(const Mesh& mesh, std::size_t t) {
  const Vec3 ab = mesh.corner(t, 1) - mesh.corner(t, 0);
  const Vec3 ac = mesh.corner(t, 2) - mesh.corner(t, 0);
  const Vec3 n = ab.cross(ac);
  const double length = n.norm();
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  // The normal of a flatter triangle is only rounding error.
  return length > 1e-12 * longest ? Vec3(n / length) : Vec3(Vec3::Zero());
}

template <class Mesh>
double corner_angle(const Mesh& mesh, std::size_t t, int k) {
  const Vec3 u = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k);
  const Vec3 v = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

// Averages face normals, weighted by angles, over the corners that share a normal. It stays shorter than a unit vector where the face
// normals cancel, or there is no face of non-zero area.
void average_normals(ShadedMesh& mesh, std::size_t faces) {
  for (Vec3& n : mesh.normals) n.setZero();
  for (std::size_t t = 0; t < faces; ++t) {
    const Vec3 face = unit_face_normal(mesh, t);
    if (face.isZero(0.0)) continue;
    for (int k = 0; k < 3; ++k) mesh.normals[mesh.corner_normals[t][k]] += corner_angle(mesh, t, k) * face;
  }
  for (Vec3& n : mesh.normals) {
    const double length = n.norm();
    if (length > 1e-9) n /= length;
  }
}

// Where there is no average, the normal becomes that of the first face with an area, or the z axis.
void replace_missing_normals(ShadedMesh& mesh, std::size_t faces) {
  const auto is_missing = [](const Vec3& n) { return n.squaredNorm() < 0.5; };
  if (std::none_of(mesh.normals.begin(), mesh.normals.end(), is_missing)) return;
  for (std::size_t t = 0; t < faces; ++t) {
    const Vec3 face = unit_face_normal(mesh, t);
    if (face.isZero(0.0)) continue;
    for (const std::uint32_t normal : mesh.corner_normals[t]) {
      if (is_missing(mesh.normals[normal])) mesh.normals[normal] = face;
    }
  }
  std::replace_if(mesh.normals.begin(), mesh.normals.end(), is_missing, Vec3(Vec3::UnitZ()));
}

}  // namespace

ShadedMesh fill_corner_normals(const TriangleMesh& mesh, std::span<const std::uint32_t> source, double crease_angle,
                               CornerNormalReport& report) {
  report = {};
  report.crease_angle_rad = crease_angle;
  ShadedMesh shaded;
  shaded.vertices = mesh.vertices;
  shaded.triangles = mesh.triangles;
  shaded.source.assign(source.begin(), source.end());
  const std::size_t count = mesh.triangles.size();

  std::vector<Vec3> faces(count);
  for (std::size_t t = 0; t < count; ++t) faces[t] = unit_face_normal(mesh, t);
  const SharedEdges edges(mesh.triangles);
  const double least_cosine = std::cos(crease_angle);
  DisjointSets corners(3 * count);
  for (std::uint32_t t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) {
      const HalfEdge* other = edges.adjacent(t, k);
      if (other == nullptr || other->triangle < t) continue;
      const std::uint32_t u = other->triangle;
      const bool is_upward = mesh.triangles[t][k] < mesh.triangles[t][(k + 1) % 3];
      const bool is_flat = faces[t].isZero(0.0) || faces[u].isZero(0.0);
      // Inconsistently oriented: the two faces have no common outside.
      const bool is_sharp = is_upward == other->upward || (!is_flat && faces[t].dot(faces[u]) < least_cosine);
      report.sharp_edges += is_sharp ? 1 : 0;
      if (is_sharp) continue;
      const std::uint32_t start = 3 * t + static_cast<std::uint32_t>(k);
      const std::uint32_t end = 3 * t + static_cast<std::uint32_t>((k + 1) % 3);
      const std::uint32_t other_start = 3 * u + other->corner;
      const std::uint32_t other_end = 3 * u + (other->corner + 1U) % 3U;
      corners.join(start, other_end);
      corners.join(end, other_start);
    }
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> normal_of_root(3 * count, kNone);
  std::vector<std::uint32_t> first_of_vertex(mesh.vertices.size(), kNone);
  std::vector<char> creased(mesh.vertices.size(), 0);
  shaded.corner_normals.resize(count);
  for (std::uint32_t c = 0; c < 3 * count; ++c) {
    std::uint32_t& normal = normal_of_root[corners.root(c)];
    if (normal == kNone) {
      normal = static_cast<std::uint32_t>(shaded.normals.size());
      shaded.normals.emplace_back(Vec3::Zero());
    }
    shaded.corner_normals[c / 3][c % 3] = normal;
    const std::uint32_t v = mesh.triangles[c / 3][c % 3];
    if (first_of_vertex[v] == kNone) first_of_vertex[v] = normal;
    if (first_of_vertex[v] != normal) creased[v] = 1;
  }
  average_normals(shaded, count);
  report.filled = 3 * count;
  report.normals = shaded.normals.size();
  report.creased = static_cast<std::size_t>(std::count(creased.begin(), creased.end(), 1));
  return shaded;
}

void update_corner_normals(ShadedMesh& mesh, std::size_t faces) {
  average_normals(mesh, faces);
  replace_missing_normals(mesh, faces);
  for (std::size_t i = 0; i < mesh.middle_normals.size(); ++i)
    mesh.normals[mesh.first_middle_normal + i] = middle_normal_of(mesh, mesh.middle_normals[i]);
}

namespace {

// The authored normal of a corner, as a unit vector; zero if there is none or it is not valid.
Vec3 valid_authored_normal(const TriangleMesh& mesh, std::size_t t, int k, const Vec3& face) {
  const Vec3 normal = mesh.authored_normals[t][k].cast<double>();
  const double length = normal.norm();
  if (!std::isfinite(length) || !(length > 0.0)) return Vec3::Zero();
  return normal.dot(face) > kMinNormalCosine * length ? Vec3(normal / length) : Vec3(Vec3::Zero());
}

// Calls use(triangle, corner, normal) for every valid authored normal.
template <class Use>
AuthoredNormalReport for_each_authored(const TriangleMesh& mesh, Use&& use) {
  AuthoredNormalReport report;
  if (!mesh.has_authored_normals()) return report;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 face = unit_face_normal(mesh, t);
    for (int k = 0; k < 3; ++k) {
      report.given += mesh.authored_normals[t][k].isZero(0.0F) ? 0 : 1;
      const Vec3 normal = valid_authored_normal(mesh, t, k, face);
      if (normal.isZero(0.0)) continue;
      ++report.used;
      use(t, k, normal);
    }
  }
  return report;
}

}  // namespace

AuthoredNormalReport count_authored_normals(const TriangleMesh& mesh) {
  return for_each_authored(mesh, [](std::size_t, int, const Vec3&) {});
}

AuthoredNormalReport use_authored_normals(const TriangleMesh& mesh, ShadedMesh& shaded) {
  // One vertex may have any number of authored normals.
  KeyTable<4> known(mesh.has_authored_normals() ? mesh.vertices.size() : 0);
  return for_each_authored(mesh, [&](std::size_t t, int k, const Vec3& normal) {
    const std::uint32_t vertex = mesh.triangles[t][k];
    const std::array<std::uint64_t, 3> words = words_of(normal);
    const auto next = static_cast<std::uint32_t>(shaded.normals.size());
    const std::uint32_t number = known.find_or_add({vertex, words[0], words[1], words[2]}, next);
    if (number == next) shaded.normals.push_back(normal);
    shaded.corner_normals[t][k] = number;
  });
}

Vec3 middle_normal_of(const ShadedMesh& mesh, const std::array<std::uint32_t, 2>& between) {
  const Vec3 sum = mesh.normals[between[0]] + mesh.normals[between[1]];
  const double length = sum.norm();
  return length > 1e-9 ? Vec3(sum / length) : mesh.normals[between[0]];
}

NormalCheckReport repair_corner_normals(ShadedMesh& mesh, std::size_t faces) {
  NormalCheckReport report;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 face = t < faces ? unit_face_normal(mesh, t) : Vec3(Vec3::Zero());
    for (int k = 0; k < 3; ++k) {
      const Vec3& n = mesh.normal(t, k);
      const bool is_unit = n.allFinite() && std::fabs(n.squaredNorm() - 1.0) < 1e-9;
      if (is_unit && (face.isZero(0.0) || n.dot(face) > kMinNormalCosine)) continue;
      ++(is_unit ? report.turned_away : report.not_unit);
      // Without an area, any direction will do: such a triangle exerts no force of its own.
      mesh.corner_normals[t][k] = static_cast<std::uint32_t>(mesh.normals.size());
      mesh.normals.push_back(face.isZero(0.0) ? Vec3(Vec3::UnitZ()) : face);
    }
  }
  return report;
}

std::string CornerNormalReport::describe() const {
  return fmt::format(
      "normals: filled {} corners with {} normals; {} sharp edges (faces turn by more than {:g} degrees), {} vertices with several", filled,
      normals, sharp_edges, crease_angle_rad * 180.0 / std::numbers::pi, creased);
}

std::string AuthoredNormalReport::describe() const {
  return given == 0 ? std::string("none")
                    : fmt::format("of {} corners, {} used by force shading, {} not valid: computed there", given, used, given - used);
}

std::string NormalCheckReport::describe() const {
  return fmt::format("validation: {} normals were not unit vectors, {} turned away from their face; both now the face's", not_unit,
                     turned_away);
}

}  // namespace hapton
