#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

using Vec3f = Eigen::Vector3f;

// The unit frame U of a mesh: its box around the origin, the longest side 2. Single precision is then as good for a mesh of 0.1 mm as for
// one of a metre.
struct DetailFrame {
  Vec3 centre = Vec3::Zero();      // frame of the mesh, m
  double scale_m = 1.0;            // metres a unit
  Eigen::Matrix4d matrix() const;  // X_SU, scale included
};

// Triangles that are drawn or left out together. Frame U.
struct DetailCluster {
  std::uint32_t first = 0;  // of the level's indices
  std::uint32_t count = 0;
  Vec3f centre = Vec3f::Zero();
  float radius = 0.0F;
  // Seen from p, all triangles show their backs when dot(normalize(cone_apex - p), cone_axis) >= cone_cutoff. 1: never all.
  Vec3f cone_apex = Vec3f::Zero();
  Vec3f cone_axis = Vec3f::Zero();
  float cone_cutoff = 1.0F;
};

// One level of detail of a mesh: what is drawn. Frame U.
struct DetailLevel {
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> indices;
  std::vector<DetailCluster> clusters;  // at least one, in the order of the indices, each index in one
  double error = 0.0;                   // how far vertices of the mesh lie from this level, the largest of a sample; 0: the mesh itself
  std::size_t triangles() const { return indices.size() / 3; }
};

DetailFrame frame_detail(const TriangleMesh& mesh);

// The mesh itself, as one cluster. RT: set-up only.
DetailLevel make_full_level(const TriangleMesh& mesh, const DetailFrame& frame);

// About that many triangles, made fast and less well (vertices clustered in a grid). None: the level has hardly more. Error not measured.
std::optional<DetailLevel> make_rough_level(const DetailLevel& full, std::size_t triangles);

// About that many triangles, by quadric error (Garland & Heckbert 1997, by meshoptimizer). None: it cannot be made with clearly fewer.
// Error not measured.
std::optional<DetailLevel> make_coarser_level(const DetailLevel& finer, std::size_t triangles);

// The largest distance of up to `samples` of the full level's vertices, evenly taken, from the level's triangles.
double measure_level_error(const DetailLevel& level, const DetailLevel& full, std::size_t samples);

// Orders the triangles so that neighbours follow each other, and divides them into clusters, about 2000 of them where a level has many
// triangles.
void divide_into_clusters(DetailLevel& level);

}  // namespace hapton
