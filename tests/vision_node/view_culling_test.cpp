#include "vision_node/view_culling.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr PictureSize kSquare{400, 400};

struct CullingCounts {
  std::size_t drawn_clusters = 0;
  std::size_t wrongly_left_out = 0;  // triangles
};

// Counts the clusters that are not left out, and, in those that are, the triangles that would be seen.
CullingCounts count_culling(const TriangleMesh& mesh, const Framing& framing, DrawnSides sides) {
  const DetailFrame frame = make_detail_frame(mesh);
  DetailLevel level = make_full_level(mesh, frame);
  divide_into_clusters(level);
  const StereoScreen screen = compute_screen(framing, kSquare);
  const Mat4 to_clip = compute_projection_matrix(screen, Eye::left) * compute_view_matrix(screen, Eye::left) * frame.matrix();
  const Vec3 p_UE = (frame.matrix().inverse() * compute_eye_position(screen, Eye::left).homogeneous()).head<3>();
  const ViewCulling culling(to_clip, p_UE, sides);
  CullingCounts counts;
  for (const DetailCluster& cluster : level.clusters) {
    if (culling.may_see(cluster)) {
      ++counts.drawn_clusters;
      continue;
    }
    for (std::uint32_t i = cluster.first; i < cluster.first + cluster.count; i += 3) {
      std::array<Vec3, 3> corner;
      bool inside = false;
      for (int k = 0; k < 3; ++k) {
        corner[k] = level.positions[level.indices[i + k]].cast<double>();
        const Vec3 at = (to_clip * corner[k].homogeneous()).hnormalized();
        inside = inside || at.cwiseAbs().maxCoeff() < 1.0;
      }
      const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      const double towards = normal.dot((p_UE - corner[0]).normalized());
      const bool is_drawn = sides == DrawnSides::both || (sides == DrawnSides::fronts ? towards > 1e-4 : towards < -1e-4);
      counts.wrongly_left_out += inside && is_drawn;
    }
  }
  return counts;
}

TEST(ViewCulling, LeavesOutWhatIsSeenFromBehindAndNothingElse) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 80'000, 1);
  const Framing framing = frame_sphere(Vec3::Zero(), 0.07, 0.063);
  const CullingCounts all = count_culling(mesh, framing, DrawnSides::both);
  const CullingCounts fronts = count_culling(mesh, framing, DrawnSides::fronts);
  EXPECT_EQ(all.wrongly_left_out, 0U);
  EXPECT_EQ(fronts.wrongly_left_out, 0U);
  EXPECT_LT(static_cast<double>(fronts.drawn_clusters), 0.75 * static_cast<double>(all.drawn_clusters));
  const CullingCounts backs = count_culling(mesh, framing, DrawnSides::backs);
  EXPECT_EQ(backs.wrongly_left_out, 0U);
  EXPECT_LT(static_cast<double>(backs.drawn_clusters), 0.75 * static_cast<double>(all.drawn_clusters));
}

TEST(ViewCulling, LeavesOutWhatIsBesideThePicture) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 80'000, 1);
  Framing framing = frame_sphere(Vec3::Zero(), 0.07, 0.063);
  const CullingCounts whole = count_culling(mesh, framing, DrawnSides::both);
  framing.view_m *= 0.25;
  const CullingCounts part = count_culling(mesh, framing, DrawnSides::both);
  EXPECT_EQ(part.wrongly_left_out, 0U);
  EXPECT_LT(part.drawn_clusters, whole.drawn_clusters / 2);
}

}  // namespace
}  // namespace hapton
