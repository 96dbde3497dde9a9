#include "vision_node/detail_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <meshoptimizer.h>

#include "core/collision/wide_bvh.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// A level has about this many clusters: few enough to be examined one by one in each frame, and small enough to be skipped as a whole when
// seen from behind. meshoptimizer takes at most 255 vertices and 512 triangles, and the number of triangles must be a multiple of four.
constexpr std::size_t kClusters = 2000;
constexpr std::size_t kClusterVertices = 255;
constexpr std::size_t kMinClusterTriangles = 16;
constexpr std::size_t kMaxClusterTriangles = 256;
constexpr float kConeWeight = 0.8F;
// A level with more than this share of the triangles that it was made from is not worth its memory.
constexpr double kMaxKeptShare = 0.8;
// More than every distance between two points of U's cube, and than its square.
constexpr double kBeyondU = 64.0;
// Largest relative residual at a texture position that a triangle reaches. It misses some if its texture corners coincide or are collinear.
constexpr double kRelativeResidual = 1e-6;
constexpr float kAnyError = std::numeric_limits<float>::max();

const float* floats(const std::vector<Vec3f>& positions) { return positions.data()->data(); }

DetailCluster make_whole_cluster(const DetailLevel& level) {
  DetailCluster cluster;
  cluster.count = static_cast<std::uint32_t>(level.indices.size());
  for (const Vec3f& p : level.positions) cluster.radius = std::max(cluster.radius, p.norm());
  return cluster;
}

// Gives the level the vertices that its triangles use and no others, in the order in which they are used.
void take_vertices(const DetailLevel& from, DetailLevel& level) {
  std::vector<unsigned int> remap(from.positions.size());
  const std::size_t used =
      meshopt_optimizeVertexFetchRemap(remap.data(), level.indices.data(), level.indices.size(), from.positions.size());
  std::vector<Vec3f> positions(used);
  meshopt_remapVertexBuffer(positions.data(), from.positions.data(), from.positions.size(), sizeof(Vec3f), remap.data());
  std::vector<VertexPaint> paints(from.paints.empty() ? 0 : used);
  if (!paints.empty()) meshopt_remapVertexBuffer(paints.data(), from.paints.data(), from.paints.size(), sizeof(VertexPaint), remap.data());
  std::vector<std::uint8_t> without_back(from.without_back.empty() ? 0 : used);
  if (!without_back.empty())
    meshopt_remapVertexBuffer(without_back.data(), from.without_back.data(), from.positions.size(), 1, remap.data());
  meshopt_remapIndexBuffer(level.indices.data(), level.indices.data(), level.indices.size(), remap.data());
  level.positions = std::move(positions);
  level.paints = std::move(paints);
  level.without_back = std::move(without_back);
}

DetailLevel compact(const DetailLevel& from, std::vector<std::uint32_t> indices) {
  DetailLevel level;
  level.indices = std::move(indices);
  take_vertices(from, level);
  level.clusters = {make_whole_cluster(level)};
  return level;
}

std::optional<DetailLevel> compact_if_worthwhile(const DetailLevel& from, std::vector<std::uint32_t> indices, std::size_t kept_indices) {
  indices.resize(kept_indices);
  if (kept_indices < 3 || static_cast<double>(kept_indices) > kMaxKeptShare * static_cast<double>(from.indices.size())) return std::nullopt;
  return compact(from, std::move(indices));
}

double compute_paint_difference(const VertexPaint& paint, const Vec3& tint, double alpha) {
  double most = std::abs(paint.alpha - alpha) / 255.0;
  for (int k = 0; k < 3; ++k) most = std::max(most, std::abs(paint.tint[static_cast<std::size_t>(k)] - tint[k]) / 255.0);
  return most;
}

// Distance in the triangle's plane from its point nearest to p to the place that looks like the wanted paint.
double measure_paint_distance(const Vec3& p, const std::array<Vec3, 3>& corners, const DetailLevel& level, std::size_t triangle,
                              const VertexPaint& target) {
  const auto paint = [&](std::size_t k) -> const VertexPaint& { return level.paints[level.indices[3 * triangle + k]]; };
  if (!paint(0).has_same_finish(target)) return kBeyondU;
  const Vec3 weights = closest_point(corners[0], corners[1], corners[2], p).barycentric;
  Vec3 tint = Vec3::Zero();
  Eigen::Vector2d texcoord = Eigen::Vector2d::Zero();
  double longest = 0.0;
  double alpha = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double weight = weights[static_cast<int>(k)];
    for (int c = 0; c < 3; ++c) tint[c] += weight * paint(k).tint[static_cast<std::size_t>(c)];
    alpha += weight * paint(k).alpha;
    texcoord += weight * paint(k).texcoord.cast<double>();
    longest = std::max(longest, (corners[(k + 1) % 3] - corners[k]).norm());
  }
  double paint_distance = compute_paint_difference(target, tint, alpha) * longest;
  const Eigen::Vector2d texcoord_offset = target.texcoord.cast<double>() - texcoord;
  if (target.layer == 0 || texcoord_offset.isZero()) return paint_distance;
  // A step (s, t) along the two edges changes the texture position by texcoord_edges * (s, t), and the position by edges * (s, t).
  Eigen::Matrix2d texcoord_edges;
  texcoord_edges << (paint(1).texcoord - paint(0).texcoord).cast<double>(), (paint(2).texcoord - paint(0).texcoord).cast<double>();
  Eigen::Matrix<double, 3, 2> edges;
  edges << corners[1] - corners[0], corners[2] - corners[0];
  const Eigen::Vector2d steps = texcoord_edges.fullPivLu().solve(texcoord_offset);
  const bool is_there =
      steps.allFinite() && (texcoord_edges * steps - texcoord_offset).norm() <= kRelativeResidual * texcoord_offset.norm();
  return paint_distance + (is_there ? (edges * steps).norm() : kBeyondU);
}

}  // namespace

Eigen::Matrix4d DetailFrame::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() *= scale_m;
  m.topRightCorner<3, 1>() = centre;
  return m;
}

DetailFrame make_detail_frame(const TriangleMesh& mesh) {
  DetailFrame frame;
  if (mesh.vertices.empty()) return frame;
  const MeshBounds bounds = compute_bounds(mesh);
  frame.centre = bounds.centre();
  // A mesh whose vertices coincide has no size, so any scale shows it.
  if (bounds.extent() > 0.0) frame.scale_m = 0.5 * bounds.extent();
  return frame;
}

DetailLevel make_full_level(const TriangleMesh& mesh, const DetailFrame& frame) {
  DetailLevel level;
  level.positions.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) level.positions.emplace_back(((v - frame.centre) / frame.scale_m).cast<float>());
  level.indices.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) level.indices.insert(level.indices.end(), t.begin(), t.end());
  level.clusters = {make_whole_cluster(level)};
  return level;
}

DetailLevel thin_out(const DetailLevel& full, std::size_t triangles) {
  const std::size_t step = std::max<std::size_t>(1, (full.triangles() + triangles - 1) / triangles);
  std::vector<std::uint32_t> indices;
  for (std::size_t t = 0; t < full.triangles(); t += step) {
    indices.insert(indices.end(), full.indices.begin() + 3 * static_cast<std::ptrdiff_t>(t),
                   full.indices.begin() + 3 * static_cast<std::ptrdiff_t>(t) + 3);
  }
  return compact(full, std::move(indices));
}

std::optional<DetailLevel> make_rough_level(const DetailLevel& full, std::size_t triangles) {
  std::vector<std::uint32_t> indices(full.indices.size());
  const std::size_t kept_indices = meshopt_simplifySloppy(indices.data(), full.indices.data(), full.indices.size(), floats(full.positions),
                                                          full.positions.size(), sizeof(Vec3f), 3 * triangles, kAnyError, nullptr);
  return compact_if_worthwhile(full, std::move(indices), kept_indices);
}

std::optional<DetailLevel> make_coarser_level(const DetailLevel& finer, std::size_t triangles) {
  std::vector<std::uint32_t> indices(finer.indices.size());
  const std::size_t kept_indices = meshopt_simplify(indices.data(), finer.indices.data(), finer.indices.size(), floats(finer.positions),
                                                    finer.positions.size(), sizeof(Vec3f), 3 * triangles, kAnyError, 0, nullptr);
  return compact_if_worthwhile(finer, std::move(indices), kept_indices);
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
  const bool is_painted = !level.paints.empty() && full.paints.size() == full.positions.size();
  double farthest_squared = 0.0;
  for (std::size_t i = 0; i < full.positions.size(); i += step) {
    const Vec3 p = full.positions[i].cast<double>();
    double nearest_squared = kBeyondU;
    tree.visit_nearest(p, nearest_squared, [&](std::uint32_t t, double) {
      const std::array<Vec3, 3> corners = {corner(t, 0), corner(t, 1), corner(t, 2)};
      double distance_squared = triangle_distance_squared(p, corners[0], corners[1], corners[2]);
      if (is_painted && distance_squared < nearest_squared) {
        const double distance = std::sqrt(distance_squared) + measure_paint_distance(p, corners, level, t, full.paints[i]);
        distance_squared = distance * distance;
      }
      nearest_squared = std::min(nearest_squared, distance_squared);
      return nearest_squared;
    });
    farthest_squared = std::max(farthest_squared, nearest_squared);
  }
  return std::sqrt(farthest_squared);
}

void divide_into_clusters(DetailLevel& level) {
  if (level.indices.empty()) return;
  const std::size_t cluster_triangles = std::clamp(level.triangles() / kClusters, kMinClusterTriangles, kMaxClusterTriangles) / 4 * 4;
  const std::size_t max_clusters = meshopt_buildMeshletsBound(level.indices.size(), kClusterVertices, cluster_triangles);
  std::vector<meshopt_Meshlet> meshlets(max_clusters);
  std::vector<unsigned int> vertices(max_clusters * kClusterVertices);
  std::vector<unsigned char> corners(max_clusters * cluster_triangles * 3);
  meshlets.resize(meshopt_buildMeshlets(meshlets.data(), vertices.data(), corners.data(), level.indices.data(), level.indices.size(),
                                        floats(level.positions), level.positions.size(), sizeof(Vec3f), kClusterVertices, cluster_triangles,
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
    cluster.shows_backs = level.without_back.empty() || std::any_of(ordered.begin() + cluster.first, ordered.end(),
                                                                    [&](std::uint32_t v) { return level.without_back[v] == 0; });
    level.clusters.push_back(cluster);
  }
  level.indices = std::move(ordered);
  take_vertices(level, level);
}

}  // namespace hapton
