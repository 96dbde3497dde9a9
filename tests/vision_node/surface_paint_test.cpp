#include "vision_node/surface_paint.h"

#include <gtest/gtest.h>

#include "vision_node/flat_level.h"

namespace hapton {
namespace {

// A flat square with sides of 1 m, with this many cells along each side.
TriangleMesh make_sheet(std::uint32_t cells) {
  TriangleMesh mesh;
  for (std::uint32_t y = 0; y <= cells; ++y) {
    for (std::uint32_t x = 0; x <= cells; ++x) mesh.vertices.emplace_back(x / double(cells), y / double(cells), 0.0);
  }
  for (std::uint32_t y = 0; y < cells; ++y) {
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t a = y * (cells + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + cells + 2});
      mesh.triangles.push_back({a, a + cells + 2, a + cells + 1});
    }
  }
  return mesh;
}

// Covers the square with one copy of an image. bend: stretches it unevenly along x; the texture coordinate is x + bend * x^2.
MeshAppearance make_textured_appearance(const TriangleMesh& mesh, float bend = 0.0F) {
  MeshAppearance appearance;
  appearance.images.push_back({"made", ""});
  appearance.materials.push_back({.name = "made", .colour = {}, .image = 0});
  for (const Triangle& t : mesh.triangles) {
    TriangleAppearance& triangle = appearance.triangles.emplace_back();
    triangle.material = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2f p = mesh.vertices[t[k]].head<2>().cast<float>();
      triangle.corners[k].texcoord = Eigen::Vector2f(p.x() + bend * p.x() * p.x(), p.y());
    }
  }
  return appearance;
}

DetailLevel make_painted(const TriangleMesh& mesh, const MeshAppearance& appearance, std::vector<std::uint8_t> layers = {1}) {
  return make_painted_level(mesh, make_detail_frame(mesh), appearance, Vec3(0.2, 0.4, 0.6), layers);
}

TEST(SurfacePaint, HasAVertexForEachPlaceAndPaint) {
  const TriangleMesh mesh = make_sheet(2);
  MeshAppearance appearance = make_textured_appearance(mesh);
  EXPECT_EQ(make_painted(mesh, appearance).positions.size(), mesh.vertices.size());
  // A seam: the last cell shows another part of the texture.
  for (std::size_t t = appearance.triangles.size() - 2; t < appearance.triangles.size(); ++t) {
    for (CornerAppearance& corner : appearance.triangles[t].corners) corner.texcoord.x() += 3.0F;
  }
  const DetailLevel level = make_painted(mesh, appearance);
  EXPECT_EQ(level.positions.size(), mesh.vertices.size() + 3) << "the last cell has four corners, one of them its alone";
  EXPECT_EQ(level.paints.size(), level.positions.size());
  EXPECT_EQ(level.paints[level.indices.back()].texcoord, appearance.triangles.back().corners[2].texcoord);
}

TEST(SurfacePaint, ComposesTheColoursThatMultiply) {
  const TriangleMesh mesh = make_sheet(1);
  MeshAppearance appearance;
  appearance.materials.push_back({.name = "", .colour = Eigen::Vector3f(1.0F, 0.5F, 0.0F), .image = {}});
  appearance.triangles.resize(2);
  appearance.triangles[0].material = 0;
  appearance.triangles[0].has_colours = true;
  appearance.triangles[0].corners[0].colour = {128, 128, 128};
  const DetailLevel level = make_painted(mesh, appearance, {});
  EXPECT_EQ(level.paints[level.indices[0]].tint, (std::array<std::uint8_t, 3>{128, 64, 0}));
  EXPECT_EQ(level.paints[level.indices[1]].tint, (std::array<std::uint8_t, 3>{255, 128, 0}));
  EXPECT_EQ(level.paints[level.indices[3]].tint, (std::array<std::uint8_t, 3>{51, 102, 153})) << "the object's own: the file says nothing";
  EXPECT_EQ(level.paints[level.indices[3]].layer, 0);
}

TEST(SurfacePaint, AnImageThatCannotBeReadLeavesTheObjectsColour) {
  const TriangleMesh mesh = make_sheet(1);
  const DetailLevel level = make_painted(mesh, make_textured_appearance(mesh), {0});
  EXPECT_EQ(level.paints[0].tint, (std::array<std::uint8_t, 3>{51, 102, 153}));
  EXPECT_EQ(level.paints[0].layer, 0);
  MeshAppearance appearance = make_textured_appearance(mesh);
  appearance.materials[0].colour_no_image = Eigen::Vector3f(1.0F, 0.0F, 1.0F);
  EXPECT_EQ(make_painted(mesh, appearance, {0}).paints[0].tint, (std::array<std::uint8_t, 3>{255, 0, 255}))
      << "the file has a colour for that";
  EXPECT_EQ(make_painted(mesh, appearance, {1}).paints[0].tint, (std::array<std::uint8_t, 3>{255, 255, 255}));
}

TEST(SurfacePaint, ShowsAnImageWhereItsMaterialPlacesIt) {
  const TriangleMesh mesh = make_sheet(1);
  MeshAppearance appearance = make_textured_appearance(mesh);
  appearance.materials[0].image_scale = {2.0F, 4.0F};
  appearance.materials[0].image_shift = {0.5F, -1.0F};
  const DetailLevel level = make_painted(mesh, appearance);
  const Eigen::Vector2f corner = appearance.triangles[0].corners[2].texcoord;
  EXPECT_EQ(level.paints[level.indices[2]].texcoord, Eigen::Vector2f(2.0F * corner.x() + 0.5F, 4.0F * corner.y() - 1.0F));
}

TEST(SurfacePaint, SaysHowATriangleIsSeenThrough) {
  const TriangleMesh mesh = make_sheet(1);
  MeshAppearance appearance = make_textured_appearance(mesh);
  VisualMaterial& material = appearance.materials[0];
  material.alpha = 0.5F;
  appearance.triangles[0].corners[0].alpha = 51;
  const auto first_corner = [&] {
    const DetailLevel level = make_painted(mesh, appearance);
    return level.paints[level.indices[0]];
  };
  EXPECT_TRUE(first_corner().is_plain()) << "opaque: its alpha means nothing";
  EXPECT_EQ(first_corner().alpha, 255);
  material.alpha_mode = AlphaMode::blend;
  EXPECT_EQ(first_corner().is_blended, 1);
  EXPECT_EQ(first_corner().alpha, 26) << "0.5 * 51";
  material.alpha_mode = AlphaMode::mask;
  EXPECT_EQ(first_corner().is_blended, 0);
  EXPECT_EQ(first_corner().cutoff, 128);
  EXPECT_EQ(first_corner().alpha, 26);
  material.alpha_cutoff = 1.25F;
  EXPECT_LT(first_corner().alpha, first_corner().cutoff) << "nothing is there";
  material.alpha_cutoff = 0.0F;
  EXPECT_EQ(first_corner().cutoff, 0) << "everything is there";
  material.alpha_cutoff = 1e-6F;
  EXPECT_EQ(first_corner().cutoff, 1);
  material = {.name = "", .image = 0, .wrap = {TextureWrap::mirror, TextureWrap::clamp}};
  EXPECT_EQ(first_corner().wraps, 1 + 4 * 2);
  EXPECT_FALSE(first_corner().is_plain());
}

// A glass pane with an opaque patch: a level without the patch has an error.
TEST(SurfacePaint, ALevelThatHasLostATransparencyHasAnError) {
  const TriangleMesh mesh = make_sheet(40);
  MeshAppearance appearance;
  appearance.materials.resize(2);
  appearance.materials[1] = {.name = "glass", .alpha_mode = AlphaMode::blend, .alpha = 0.2F};
  appearance.triangles.resize(mesh.triangles.size());
  const auto paint_patch = [&](double radius) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      appearance.triangles[t].material = (mesh.corner(t, 0).head<2>() - Eigen::Vector2d(0.5, 0.5)).norm() < radius ? 0 : 1;
    }
    return make_painted(mesh, appearance, {});
  };
  const DetailLevel with_patch = paint_patch(0.2);
  const DetailLevel without = paint_patch(0.0);
  EXPECT_GT(measure_level_error(without, with_patch, 4000), 0.2) << "from the patch's middle there is nothing opaque";
  EXPECT_LT(measure_level_error(with_patch, with_patch, 4000), 1e-6);
  appearance.materials[1].alpha = 0.7F;
  EXPECT_GT(measure_level_error(without, paint_patch(0.0), 4000), 0.01) << "half the opacity of the finest triangles";
}

// If the texture coordinates are linear over a plane, few triangles show the texture as well as many.
TEST(SurfacePaint, TextureCoordinatesSurviveSimplification) {
  const TriangleMesh mesh = make_sheet(40);
  const DetailLevel full = make_painted(mesh, make_textured_appearance(mesh));
  const auto coarser = make_coarser_level(full, 100);
  ASSERT_TRUE(coarser);
  ASSERT_LE(coarser->triangles(), 100U);
  ASSERT_EQ(coarser->paints.size(), coarser->positions.size());
  for (std::size_t i = 0; i < coarser->positions.size(); ++i) {
    const Vec3f& p = coarser->positions[i];
    EXPECT_NEAR(coarser->paints[i].texcoord.x(), 0.5F * (p.x() + 1.0F), 1e-5);
    EXPECT_NEAR(coarser->paints[i].texcoord.y(), 0.5F * (p.y() + 1.0F), 1e-5);
  }
  EXPECT_LT(measure_level_error(*coarser, full, 4000), 1e-4);
  DetailLevel divided = *coarser;
  divide_into_clusters(divided);
  const FlatLevel flat = make_flat(divided);
  ASSERT_EQ(flat.paints.size(), flat.vertices.size());
  for (std::size_t i = 0; i < flat.vertices.size(); ++i) {
    EXPECT_NEAR(flat.paints[i].texcoord.x(), 0.5F * (flat.vertices[i].position.x() + 1.0F), 1e-5);
  }
}

// The level's shape is exact, but its texture has shifted: the error includes that, so full detail is drawn where the shift would be seen.
TEST(SurfacePaint, ALevelWhoseTextureHasSlippedHasThatError) {
  const TriangleMesh mesh = make_sheet(40);
  const DetailLevel full = make_painted(mesh, make_textured_appearance(mesh, 1.0F));
  const auto coarser = make_coarser_level(full, 8);
  ASSERT_TRUE(coarser);
  const double error = measure_level_error(*coarser, full, 4000);
  EXPECT_GT(error, 0.02);
  DetailLevel untextured = *coarser;
  untextured.paints.clear();
  EXPECT_LT(measure_level_error(untextured, full, 4000), 1e-6) << "without its texture it is the same plane";
}

TEST(SurfacePaint, ALevelThatHasLostAColourHasAnError) {
  const TriangleMesh mesh = make_sheet(40);
  MeshAppearance appearance;
  appearance.triangles.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    appearance.triangles[t].has_colours = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = mesh.corner(t, static_cast<int>(k));
      const bool is_spot = (p.head<2>() - Eigen::Vector2d(0.5, 0.5)).norm() < 0.1;
      appearance.triangles[t].corners[k].colour =
          is_spot ? std::array<std::uint8_t, 3>{255, 0, 0} : std::array<std::uint8_t, 3>{255, 255, 255};
    }
  }
  const DetailLevel full = make_painted(mesh, appearance, {});
  EXPECT_EQ(full.positions.size(), mesh.vertices.size());
  const auto coarser = make_coarser_level(full, 8);
  ASSERT_TRUE(coarser);
  EXPECT_GT(measure_level_error(*coarser, full, 4000), 0.05);
  EXPECT_LT(measure_level_error(full, full, 4000), 1e-6);
}

}  // namespace
}  // namespace hapton
