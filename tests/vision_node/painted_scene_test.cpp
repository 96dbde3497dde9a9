// What a mesh file says of colours and textures is in the picture.
#include <gtest/gtest.h>

#include "tests/vision_node/made_images.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/scene_painter.h"
#include "vision_node/texture_layers.h"

namespace hapton {
namespace {

constexpr double kHalf = 0.08;

// A square that faces the viewer, of so many cells a side.
std::shared_ptr<TriangleMesh> make_square(std::uint32_t cells) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (std::uint32_t y = 0; y <= cells; ++y) {
    for (std::uint32_t x = 0; x <= cells; ++x)
      mesh->vertices.emplace_back(kHalf * (2.0 * x / cells - 1), kHalf * (2.0 * y / cells - 1), 0.0);
  }
  for (std::uint32_t y = 0; y < cells; ++y) {
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t a = y * (cells + 1) + x;
      mesh->triangles.push_back({a, a + 1, a + cells + 2});
      mesh->triangles.push_back({a, a + cells + 2, a + cells + 1});
    }
  }
  return mesh;
}

std::shared_ptr<MeshLook> lay_image(const TriangleMesh& mesh, std::string png) {
  auto look = std::make_shared<MeshLook>();
  look->images.push_back({"made", std::move(png)});
  look->materials.push_back({.name = "", .colour = {}, .image = 0});
  for (const Triangle& t : mesh.triangles) {
    TriangleLook& triangle = look->triangles.emplace_back();
    triangle.material = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.vertices[t[k]];
      triangle.corners[k].texcoord =
          Eigen::Vector2f(static_cast<float>(0.5 + 0.5 * p.x() / kHalf), static_cast<float>(0.5 - 0.5 * p.y() / kHalf));
    }
  }
  return look;
}

std::array<int, 3> pixel_at(StereoView& view, const Picture& picture, const Vec3& p_W) {
  const Vec2 at = project_to_pixel(view.screen(), Eye::centre, view.picture_size(), p_W);
  const std::uint8_t* rgb = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
  return {rgb[0], rgb[1], rgb[2]};
}

void expect_quarters(StereoView& view, int tolerance) {
  const Picture picture = view.read_picture();
  const auto near = [&](double x, double y, const std::array<int, 3>& wanted) {
    const auto seen = pixel_at(view, picture, Vec3(x * kHalf, y * kHalf, 0.0));
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(seen[k], wanted[k], tolerance) << x << " " << y << " channel " << k;
  };
  near(-0.5, 0.5, {255, 0, 0});
  near(0.5, 0.5, {0, 255, 0});
  near(-0.5, -0.5, {0, 0, 255});
  near(0.5, -0.5, {255, 255, 255});
  // Up to the boundary of two colours.
  near(-0.05, 0.5, {255, 0, 0});
  near(0.05, 0.5, {0, 255, 0});
}

TEST(PaintedScene, ShowsTheTextureTheRightWayUp) {
  const auto mesh = make_square(1);
  const auto view =
      open_or_fail(plain_settings(StereoMode::mono, 400, 400), {{mesh, Vec3(0.5, 0.5, 0.5), lay_image(*mesh, make_quarters_png(64))}});
  ASSERT_TRUE(view);
  view->draw();
  expect_quarters(*view, 3);
}

// 80,000 triangles: a level of detail is drawn while it turns, and shows the same texture.
TEST(PaintedScene, ShowsTheTextureInACoarserLevelAndInFullDetail) {
  const auto mesh = make_square(200);
  const auto view =
      open_or_fail(plain_settings(StereoMode::mono, 400, 400), {{mesh, Vec3(0.5, 0.5, 0.5), lay_image(*mesh, make_quarters_png(64))}});
  ASSERT_TRUE(view);
  for (int i = 0; i < 3000 && view->detail_progress() < 1.0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  view->refine();
  view->draw();
  EXPECT_LT(view->paint_count().triangles, mesh->triangles.size() / 4);
  expect_quarters(*view, 3);
  while (view->refine()) view->draw();
  expect_quarters(*view, 3);
}

TEST(PaintedScene, GoesFromColourToColourBetweenVertices) {
  const auto mesh = make_square(1);
  auto look = std::make_shared<MeshLook>();
  for (const Triangle& t : mesh->triangles) {
    TriangleLook& triangle = look->triangles.emplace_back();
    triangle.has_colours = true;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.corners[k].colour =
          mesh->vertices[t[k]].x() < 0 ? std::array<std::uint8_t, 3>{255, 0, 0} : std::array<std::uint8_t, 3>{0, 0, 255};
    }
  }
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400), {{mesh, Vec3(0.5, 0.5, 0.5), look}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  EXPECT_NEAR(pixel_at(*view, picture, {-0.5 * kHalf, 0.3 * kHalf, 0})[0], 191, 4);
  EXPECT_NEAR(pixel_at(*view, picture, {0.0, 0.0, 0})[0], 128, 4);
  EXPECT_NEAR(pixel_at(*view, picture, {0.5 * kHalf, -0.3 * kHalf, 0})[2], 191, 4);
  EXPECT_EQ(pixel_at(*view, picture, {0.0, 0.0, 0})[1], 0);
}

// Objects with and without a look beside each other; an image that cannot be read.
TEST(PaintedScene, LeavesOtherObjectsAsTheyAre) {
  const auto mesh = make_square(1);
  auto moved = std::make_shared<TriangleMesh>(*mesh);
  for (Vec3& p : moved->vertices) p = 0.4 * p + Vec3(0.0, 0.0, 0.05);
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400),
                                 {{mesh, Vec3(0.5, 0.5, 0.5), lay_image(*mesh, "no image at all")}, {moved, Vec3(1.0, 0.5, 0.0)}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  EXPECT_EQ(pixel_at(*view, picture, {0.8 * kHalf, 0.8 * kHalf, 0}), (std::array{128, 128, 128}));
  EXPECT_EQ(pixel_at(*view, picture, {0.0, 0.0, 0.05}), (std::array{255, 128, 0}));
}

}  // namespace
}  // namespace hapton
