#include "vision_node/detail_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <meshoptimizer.h>

#include "core/collision/wide_bvh.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// A level has about so many clusters: few enough to be looked at one by one for each picture, small enough to be left out as a whole when
// they are seen from behind. meshoptimizer takes 255 vertices and 512 triangles at most, triangles by fours.
constexpr std::size_t kClusters = 2000;
constexpr std::size_t kClusterVertices = 255;
constexpr std::size_t kLeastClusterTriangles = 16;
constexpr std::size_t kMostClusterTriangles = 256;
constexpr float kConeWeight = 0.8F;
// A level that saves less is not worth its memory.
constexpr double kWorthwhile = 0.8;
// Squared; no two points of U's cube are so far apart.
constexpr double kBeyondU = 64.0;
constexpr float kAnyError = std::numeric_limits<float>::max();

const float* floats(const std::vector<Vec3f>& positions) { return positions.data()->data(); }

DetailCluster whole(const DetailLevel& level) {
  DetailCluster cluster;
  cluster.count = static_cast<std::uint32_t>(level.indices.size());
  for (const Vec3f& p : level.positions) cluster.radius = std::max(cluster.radius, p.norm());
  return cluster;
}

// A level of these triangles, with the vertices they use and no others, in the order they are used.
DetailLevel compact(const std::vector<Vec3f>& positions, std::vector<std::uint32_t> indices) {
  DetailLevel level;
  level.indices = std::move(indices);
  level.positions.resize(positions.size());
  const std::size_t used = meshopt_optimizeVertexFetch(level.positions.data(), level.indices.data(), level.indices.size(), positions.data(),
                                                       positions.size(), sizeof(Vec3f));
  level.positions.resize(used);
  level.positions.shrink_to_fit();
  level.clusters = {whole(level)};
  return level;
}

std::optional<DetailLevel> if_worthwhile(const DetailLevel& from, std::vector<std::uint32_t> indices, std::size_t kept) {
  indices.resize(kept);
  if (kept < 3 || static_cast<double>(kept) > kWorthwhile * static_cast<double>(from.indices.size())) return std::nullopt;
  return compact(from.positions, std::move(indices));
}

}  // namespace

Eigen::Matrix4d DetailFrame::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() *= scale_m;
  m.topRightCorner<3, 1>() = centre;
  return m;
}

DetailFrame frame_detail(const TriangleMesh& mesh) {
  DetailFrame frame;
  if (mesh.vertices.empty()) return frame;
  const MeshBounds bounds = compute_bounds(mesh);
  frame.centre = bounds.centre();
  // A mesh of one point has no size; any scale shows it.
  if (bounds.extent() > 0.0) frame.scale_m = 0.5 * bounds.extent();
  return frame;
}

DetailLevel make_full_level(const TriangleMesh& mesh, const DetailFrame& frame) {
  DetailLevel level;
  level.positions.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) level.positions.emplace_back(((v - frame.centre) / frame.scale_m).cast<float>());
  level.indices.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) level.indices.insert(level.indices.end(), t.begin(), t.end());
  level.clusters = {whole(level)};
  return level;
}

std::optional<DetailLevel> make_rough_level(const DetailLevel& full, std::size_t triangles) {
  std::vector<std::uint32_t> indices(full.indices.size());
  const std::size_t kept = meshopt_simplifySloppy(indices.data(), full.indices.data(), full.indices.size(), floats(full.positions),
                                                  full.positions.size(), sizeof(Vec3f), 3 * triangles, kAnyError, nullptr);
  return if_worthwhile(full, std::move(indices), kept);
}

std::optional<DetailLevel> make_coarser_level(const DetailLevel& finer, std::size_t triangles) {
  std::vector<std::uint32_t> indices(finer.indices.size());
  const std::size_t kept = meshopt_simplify(indices.data(), finer.indices.data(), finer.indices.size(), floats(finer.positions),
                                            finer.positions.size(), sizeof(Vec3f), 3 * triangles, kAnyError, 0, nullptr);
  return if_worthwhile(finer, std::move(indices), kept);
}

double measure_level_error(const DetailLevel& level, const DetailLevel& full, std::size_t samples) {
  if (level.indices.empty()) return std::numeric_limits<double>::infinity();
  const auto corner = [&](std::size_t t, int k) -> Vec3 { return level.positions[level.indices[3 * t + k]].cast<double>(); };
  const WideBvh tree(level.triangles(), [&](std::size_t t) {
    Box box;
    for (int k = 0; k < 3; ++k) box.grow(corner(t, k));
    return box;
  });
  const std::size_t step = std::max<std::size_t>(1, full.positions.size() / std::max<std::size_t>(1, samples));
  double farthest = 0.0;
  for (std::size_t i = 0; i < full.positions.size(); i += step) {
    const Vec3 p = full.positions[i].cast<double>();
    double least = kBeyondU;
    tree.visit_nearest(p, least, [&](std::uint32_t t, double) {
      least = std::min(least, triangle_distance_squared(p, corner(t, 0), corner(t, 1), corner(t, 2)));
      return least;
    });
    farthest = std::max(farthest, least);
  }
  return std::sqrt(farthest);
}

void divide_into_clusters(DetailLevel& level) {
  if (level.indices.empty()) return;
  const std::size_t at_most = std::clamp(level.triangles() / kClusters, kLeastClusterTriangles, kMostClusterTriangles) / 4 * 4;
  const std::size_t most = meshopt_buildMeshletsBound(level.indices.size(), kClusterVertices, at_most);
  std::vector<meshopt_Meshlet> meshlets(most);
  std::vector<unsigned int> vertices(most * kClusterVertices);
  std::vector<unsigned char> corners(most * at_most * 3);
  meshlets.resize(meshopt_buildMeshlets(meshlets.data(), vertices.data(), corners.data(), level.indices.data(), level.indices.size(),
                                        floats(level.positions), level.positions.size(), sizeof(Vec3f), kClusterVertices, at_most,
                                        kConeWeight));
  std::vector<std::uint32_t> ordered;
  ordered.reserve(level.indices.size());
  level.clusters.clear();
  for (const meshopt_Meshlet& m : meshlets) {
    DetailCluster cluster;
    cluster.first = static_cast<std::uint32_t>(ordered.size());
    cluster.count = 3 * m.triangle_count;
    for (std::size_t i = 0; i < cluster.count; ++i) ordered.push_back(vertices[m.vertex_offset + corners[m.triangle_offset + i]]);
    const meshopt_Bounds bounds = meshopt_computeMeshletBounds(&vertices[m.vertex_offset], &corners[m.triangle_offset], m.triangle_count,
                                                               floats(level.positions), level.positions.size(), sizeof(Vec3f));
    cluster.centre = Vec3f(bounds.center);
    cluster.radius = bounds.radius;
    cluster.cone_apex = Vec3f(bounds.cone_apex);
    cluster.cone_axis = Vec3f(bounds.cone_axis);
    cluster.cone_cutoff = bounds.cone_cutoff;
    level.clusters.push_back(cluster);
  }
  const std::vector<Vec3f> positions = std::move(level.positions);
  level.indices = std::move(ordered);
  level.positions.resize(positions.size());
  level.positions.resize(meshopt_optimizeVertexFetch(level.positions.data(), level.indices.data(), level.indices.size(), positions.data(),
                                                     positions.size(), sizeof(Vec3f)));
}

}  // namespace hapton
