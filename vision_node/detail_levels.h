#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_appearance.h"

namespace hapton {

using Vec3f = Eigen::Vector3f;

// The unit frame U of a mesh: its box is centred at the origin, and the longest side is 2. Single precision is then as good for a mesh of
// 0.1 mm as for one of a metre.
struct DetailFrame {
  Vec3 centre = Vec3::Zero();      // in the frame of the mesh, m
  double scale_m = 1.0;            // metres in one unit of U
  Eigen::Matrix4d matrix() const;  // from U to the mesh's frame, scale included
};

// Triangles that are drawn or left out together. Frame U.
struct DetailCluster {
  std::uint32_t first = 0;  // index of the first corner in the level's indices
  std::uint32_t count = 0;
  Vec3f centre = Vec3f::Zero();
  float radius = 0.0F;
  // Seen from p, all triangles show their backs when dot(normalize(cone_apex - p), cone_axis) >= cone_cutoff. 1: never all.
  Vec3f cone_apex = Vec3f::Zero();
  Vec3f cone_axis = Vec3f::Zero();
  float cone_cutoff = 1.0F;
  bool shows_backs = true;  // false: its triangles belong to closed bodies with their fronts outside, which no eye sees from behind
};

// The colour of the surface at a vertex.
struct VertexPaint {
  std::array<std::uint8_t, 3> tint = {255, 255, 255};  // sRGB
  std::uint8_t layer = 0;                              // texture layer of the mesh, from 1, multiplied by tint; 0: none. One for a triangle
  Eigen::Vector2f texcoord = Eigen::Vector2f::Zero();  // in the layer, from its upper left corner
  std::uint8_t alpha = 255;                            // multiplies the layer's; 255: opaque
  // One for all of a triangle, as are the next two. Where the alpha is below the cutoff, nothing is drawn; 0: all is drawn, and alpha has
  // no effect unless is_blended.
  std::uint8_t cutoff = 0;
  std::uint8_t is_blended = 0;  // 0 or 1: it covers what is behind it in proportion to alpha
  std::uint8_t wraps = 0;       // of the layer: TextureWrap to the right, plus 4 times that down

  void set_wrap(const std::array<TextureWrap, 2>& wrap) {
    wraps = static_cast<std::uint8_t>(static_cast<int>(wrap[0]) + 4 * static_cast<int>(wrap[1]));
  }
  // Whether it has neither holes nor transparency nor a texture that ends: the shortest shader then draws it.
  bool is_plain() const { return cutoff == 0 && is_blended == 0 && wraps == 0; }
  bool has_same_finish(const VertexPaint& other) const {
    return layer == other.layer && cutoff == other.cutoff && is_blended == other.is_blended && wraps == other.wraps;
  }
  friend bool operator==(const VertexPaint& a, const VertexPaint& b) {
    return a.tint == b.tint && a.texcoord == b.texcoord && a.alpha == b.alpha && a.has_same_finish(b);
  }
};

// One level of detail of a mesh, as drawn. Frame U.
struct DetailLevel {
  std::vector<Vec3f> positions;
  std::vector<VertexPaint> paints;         // by position; empty: the mesh has one colour
  std::vector<std::uint8_t> without_back;  // by position, 1: only of bodies whose backs nobody sees (shows_backs); empty: unknown
  std::vector<std::uint32_t> indices;
  std::vector<DetailCluster> clusters;  // at least one, in the order of the indices, each index in one
  double error = 0.0;                   // in U, from measure_level_error(); 0: the mesh itself
  std::size_t triangles() const { return indices.size() / 3; }
};

DetailFrame make_detail_frame(const TriangleMesh& mesh);

// The mesh itself, as one cluster. RT: set-up only.
DetailLevel make_full_level(const TriangleMesh& mesh, const DetailFrame& frame);

// At most that many of the mesh's triangles, evenly spaced in its list, made quickly: the picture then has holes. Pre: triangles > 0. The
// error is not measured.
DetailLevel thin_out(const DetailLevel& full, std::size_t triangles);

// About that many triangles, made quickly and less well (by a grid of vertices). None: it would have hardly fewer. Error not measured.
std::optional<DetailLevel> make_rough_level(const DetailLevel& full, std::size_t triangles);

// About that many triangles, by quadric error (Garland & Heckbert 1997, by meshoptimizer). None: they would not be clearly fewer. The error
// is not measured.
std::optional<DetailLevel> make_coarser_level(const DetailLevel& finer, std::size_t triangles);

// The largest distance, in U, of the full level's vertices from the level's triangles: of all, or of `samples` to twice as many, evenly
// spaced. For a painted level, the distance to the same paint: the distance to a triangle, plus that on it to the vertex's texture
// position, plus the difference of colours or alphas times its longest side. So if no level has good paint, the mesh itself is drawn.
double measure_level_error(const DetailLevel& level, const DetailLevel& full, std::size_t samples);

// Orders the triangles so that neighbours follow each other, and divides them into about 2000 clusters: fewer for a small level, as
// clusters of up to 16 triangles are allowed, and more above 512,000 triangles, as none has more than 256.
void divide_into_clusters(DetailLevel& level);

}  // namespace hapton
