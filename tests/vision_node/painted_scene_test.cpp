// The colours and textures of a mesh file are visible in the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include "tests/vision_node/made_images.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/scene_painter.h"
#include "vision_node/texture_layers.h"

namespace hapton {
namespace {

constexpr double kHalfSide = 0.08;

// A square that faces the viewer, with this many cells on each side.
std::shared_ptr<TriangleMesh> make_square(std::uint32_t cells) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (std::uint32_t y = 0; y <= cells; ++y) {
    for (std::uint32_t x = 0; x <= cells; ++x)
      mesh->vertices.emplace_back(kHalfSide * (2.0 * x / cells - 1), kHalfSide * (2.0 * y / cells - 1), 0.0);
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

std::shared_ptr<MeshAppearance> make_image_appearance(const TriangleMesh& mesh, std::string png) {
  auto appearance = std::make_shared<MeshAppearance>();
  appearance->images.push_back({"made", std::move(png)});
  appearance->materials.push_back({.name = "", .colour = {}, .image = 0});
  for (const Triangle& t : mesh.triangles) {
    TriangleAppearance& triangle = appearance->triangles.emplace_back();
    triangle.material = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.vertices[t[k]];
      triangle.corners[k].texcoord =
          Eigen::Vector2f(static_cast<float>(0.5 + 0.5 * p.x() / kHalfSide), static_cast<float>(0.5 - 0.5 * p.y() / kHalfSide));
    }
  }
  return appearance;
}

std::array<int, 3> pixel_at(StereoView& view, const Picture& picture, const Vec3& p_W) {
  const Vec2 at = project_to_pixel(view.screen(), Eye::centre, view.picture_size(), p_W);
  const std::uint8_t* rgb = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
  return {rgb[0], rgb[1], rgb[2]};
}

void expect_quarters(StereoView& view, int tolerance) {
  const Picture picture = view.read_picture();
  const auto expect_at = [&](double x, double y, const std::array<int, 3>& expected) {
    const auto actual = pixel_at(view, picture, Vec3(x * kHalfSide, y * kHalfSide, 0.0));
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(actual[k], expected[k], tolerance) << x << " " << y << " channel " << k;
  };
  expect_at(-0.5, 0.5, {255, 0, 0});
  expect_at(0.5, 0.5, {0, 255, 0});
  expect_at(-0.5, -0.5, {0, 0, 255});
  expect_at(0.5, -0.5, {255, 255, 255});
  // Close to the boundary between two colours.
  expect_at(-0.05, 0.5, {255, 0, 0});
  expect_at(0.05, 0.5, {0, 255, 0});
}

TEST(PaintedScene, ShowsTheTextureTheRightWayUp) {
  const auto mesh = make_square(1);
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400),
                                 {{mesh, Vec3(0.5, 0.5, 0.5), make_image_appearance(*mesh, make_quarters_png(64))}});
  ASSERT_TRUE(view);
  view->draw();
  expect_quarters(*view, 3);
}

// 80,000 triangles: a coarser level of detail is drawn while the scene moves, and it shows the same texture.
TEST(PaintedScene, ShowsTheTextureInACoarserLevelAndInFullDetail) {
  const auto mesh = make_square(200);
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400),
                                 {{mesh, Vec3(0.5, 0.5, 0.5), make_image_appearance(*mesh, make_quarters_png(64))}});
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
  auto appearance = std::make_shared<MeshAppearance>();
  for (const Triangle& t : mesh->triangles) {
    TriangleAppearance& triangle = appearance->triangles.emplace_back();
    triangle.has_colours = true;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.corners[k].colour =
          mesh->vertices[t[k]].x() < 0 ? std::array<std::uint8_t, 3>{255, 0, 0} : std::array<std::uint8_t, 3>{0, 0, 255};
    }
  }
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400), {{mesh, Vec3(0.5, 0.5, 0.5), appearance}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  // A quarter of the way from one colour to the other: 191 = 0.75 * 255.
  EXPECT_NEAR(pixel_at(*view, picture, {-0.5 * kHalfSide, 0.3 * kHalfSide, 0})[0], 191, 4);
  EXPECT_NEAR(pixel_at(*view, picture, {0.0, 0.0, 0})[0], 128, 4);
  EXPECT_NEAR(pixel_at(*view, picture, {0.5 * kHalfSide, -0.3 * kHalfSide, 0})[2], 191, 4);
  EXPECT_EQ(pixel_at(*view, picture, {0.0, 0.0, 0})[1], 0);
}

// Texture coordinates from -1 to 2 over the square: the image is in the middle, and what lies beyond its edges is on all sides.
std::shared_ptr<MeshAppearance> make_wrapped_appearance(const TriangleMesh& mesh, std::array<TextureWrap, 2> wrap, int side) {
  auto appearance = make_image_appearance(mesh, make_quarters_png(side));
  appearance->materials[0].wrap = wrap;
  for (TriangleAppearance& triangle : appearance->triangles) {
    for (CornerAppearance& corner : triangle.corners) corner.texcoord = 3.0F * corner.texcoord - Eigen::Vector2f(1.0F, 1.0F);
  }
  return appearance;
}

// The place in the image, 0 to 1, from which a place beyond its edges gets its colour (glTF 2.0, 3.8.4).
double wrap_place(TextureWrap wrap, double at) {
  if (wrap == TextureWrap::clamp) return std::clamp(at, 0.0, 1.0);
  const double whole = std::floor(at);
  const bool is_turned = wrap == TextureWrap::mirror && std::fmod(std::abs(whole), 2.0) == 1.0;
  return is_turned ? 1.0 - (at - whole) : at - whole;
}

void expect_wrapped(StereoView& view, std::array<TextureWrap, 2> wrap) {
  const Picture picture = view.read_picture();
  // At least 0.1 away from the boundaries of colours within the image, but close to the edges of the image.
  for (const double right : {-0.9, -0.6, -0.4, -0.03, 0.03, 0.4, 0.6, 0.97, 1.03, 1.4, 1.6, 1.9}) {
    for (const double down : {-0.9, -0.6, -0.4, -0.03, 0.03, 0.4, 0.6, 0.97, 1.03, 1.4, 1.6, 1.9}) {
      const bool is_right = wrap_place(wrap[0], right) > 0.5;
      const bool is_low = wrap_place(wrap[1], down) > 0.5;
      const auto expected = is_low ? (is_right ? std::array{255, 255, 255} : std::array{0, 0, 255})
                                   : (is_right ? std::array{0, 255, 0} : std::array{255, 0, 0});
      const Vec3 p_W(kHalfSide * ((right + 1.0) / 1.5 - 1.0), kHalfSide * (1.0 - (down + 1.0) / 1.5), 0.0);
      const auto actual = pixel_at(view, picture, p_W);
      for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(actual[k], expected[k], 3) << right << " " << down << " channel " << k;
    }
  }
}

TEST(PaintedScene, RepeatsMirrorsOrEndsATextureBeyondItsEdges) {
  const auto mesh = make_square(1);
  for (const TextureWrap across : {TextureWrap::repeat, TextureWrap::mirror, TextureWrap::clamp}) {
    for (const TextureWrap down : {TextureWrap::repeat, TextureWrap::mirror, TextureWrap::clamp}) {
      // 32 texels are drawn enlarged, 1024 reduced: then the texels at the edge are those of another mipmap level.
      for (const int side : {32, 1024}) {
        SCOPED_TRACE(testing::Message() << "wrap " << int(across) << " " << int(down) << ", " << side << " texels");
        const auto view = open_or_fail(plain_settings(StereoMode::mono, 500, 500),
                                       {{mesh, Vec3(0.5, 0.5, 0.5), make_wrapped_appearance(*mesh, {across, down}, side)}});
        ASSERT_TRUE(view);
        view->draw();
        // Within half a texel of an edge a repeating texture shows both sides of the edge: with 32 texels such a texture is not checked.
        if (side == 1024 || (across != TextureWrap::repeat && down != TextureWrap::repeat)) expect_wrapped(*view, {across, down});
      }
    }
  }
}

TEST(PaintedScene, WrapsInACoarserLevelAndInFullDetail) {
  const auto mesh = make_square(200);
  const std::array wrap = {TextureWrap::clamp, TextureWrap::mirror};
  const auto view =
      open_or_fail(plain_settings(StereoMode::mono, 500, 500), {{mesh, Vec3(0.5, 0.5, 0.5), make_wrapped_appearance(*mesh, wrap, 256)}});
  ASSERT_TRUE(view);
  wait_for_levels(*view);
  view->refine();
  view->draw();
  EXPECT_LT(view->paint_count().triangles, mesh->triangles.size() / 4);
  expect_wrapped(*view, wrap);
  while (view->refine()) view->draw();
  expect_wrapped(*view, wrap);
}

std::shared_ptr<TriangleMesh> move_towards_viewer(TriangleMesh mesh, double by_m, double scale = 1.0) {
  for (Vec3& p : mesh.vertices) p = scale * p + Vec3(0.0, 0.0, by_m);
  return std::make_shared<TriangleMesh>(std::move(mesh));
}

std::shared_ptr<MeshAppearance> tint(const TriangleMesh& mesh, const Eigen::Vector3f& colour, float alpha,
                                     AlphaMode mode = AlphaMode::blend) {
  auto appearance = std::make_shared<MeshAppearance>();
  appearance->materials.push_back({.name = "glass", .colour = colour, .alpha_mode = mode, .alpha = alpha});
  appearance->triangles.resize(mesh.triangles.size());
  for (TriangleAppearance& triangle : appearance->triangles) triangle.material = 0;
  return appearance;
}

void expect_colour(StereoView& view, const Vec3& p_W, const std::array<double, 3>& expected, double tolerance = 2.0) {
  const auto actual = pixel_at(view, view.read_picture(), p_W);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(actual[k], expected[k], tolerance) << "channel " << k;
}

// Two panes of glass in front of a wall: the nearer one covers the farther one, in whatever order the scene has them.
TEST(PaintedScene, BlendsPanesOfGlassFromTheFarthestToTheNearest) {
  const auto wall = make_square(1);
  const auto red = move_towards_viewer(*wall, 0.02, 0.8);
  const auto blue = move_towards_viewer(*wall, 0.04, 0.6);
  const ShownObject behind = {wall, Vec3(0.0, 1.0, 0.0)};
  const ShownObject middle = {red, Vec3(0.5, 0.5, 0.5), tint(*red, {1, 0, 0}, 0.4F)};
  const ShownObject front = {blue, Vec3(0.5, 0.5, 0.5), tint(*blue, {0, 0, 1}, 0.6F)};
  for (const std::vector<ShownObject>& objects :
       {std::vector{behind, middle, front}, std::vector{front, middle, behind}, std::vector{middle, front, behind}}) {
    const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400), objects);
    ASSERT_TRUE(view);
    view->draw();
    expect_colour(*view, {0.9 * kHalfSide, 0.9 * kHalfSide, 0.0}, {0, 255, 0});
    expect_colour(*view, {0.7 * kHalfSide, 0.0, 0.02}, {0.4 * 255, 0.6 * 255, 0});
    expect_colour(*view, {0.0, 0.0, 0.04}, {0.4 * 0.4 * 255, 0.4 * 0.6 * 255, 0.6 * 255});
    const auto picked = view->pick(200, 200);
    ASSERT_TRUE(picked);
    EXPECT_NEAR(picked->z(), 0.04, 1e-4) << "glass is felt, so it can be pointed at";
  }
}

// One mesh of two squares, one behind the other, seen from both sides: the triangles of one mesh are drawn in order, too.
TEST(PaintedScene, BlendsTheTrianglesOfOneMeshInOrder) {
  TriangleMesh both = *make_square(1);
  const TriangleMesh back = *move_towards_viewer(both, -0.03);
  for (const Triangle& t : back.triangles) both.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  both.vertices.insert(both.vertices.end(), back.vertices.begin(), back.vertices.end());
  auto appearance = tint(both, {1, 0, 0}, 0.5F);
  appearance->materials.push_back({.name = "other", .colour = Eigen::Vector3f(0, 0, 1), .alpha_mode = AlphaMode::blend, .alpha = 0.5F});
  appearance->triangles[2].material = appearance->triangles[3].material = 1;
  const auto view =
      open_or_fail(plain_settings(StereoMode::mono, 400, 400), {{std::make_shared<TriangleMesh>(both), Vec3::Ones(), appearance}});
  ASSERT_TRUE(view);
  view->set_cull(false);
  view->draw();
  expect_colour(*view, {0.1 * kHalfSide, 0.2 * kHalfSide, 0.0}, {128, 0, 64});
  Pose turned_around = Pose::Identity();
  turned_around.linear() = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitY()).toRotationMatrix();
  view->set_scene_pose(turned_around);
  view->draw();
  expect_colour(*view, {0.1 * kHalfSide, 0.2 * kHalfSide, 0.03}, {64, 0, 128});
}

// 80,000 triangles of glass in front of a wall: in a coarser level, and in full detail, which is drawn in parts.
TEST(PaintedScene, BlendsACoarserLevelAndFullDetail) {
  const auto wall = make_square(1);
  const auto pane = move_towards_viewer(*make_square(200), 0.03);
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400),
                                 {{pane, Vec3::Ones(), tint(*pane, {1, 0, 0}, 0.25F)}, {wall, Vec3(0.0, 1.0, 1.0)}});
  ASSERT_TRUE(view);
  wait_for_levels(*view);
  const auto expect_blended = [&] {
    for (int i = -4; i <= 4; ++i) expect_colour(*view, {0.2 * i * kHalfSide, 0.17 * i * kHalfSide, 0.03}, {64, 191, 191});
  };
  view->refine();
  view->draw();
  EXPECT_LT(view->paint_count().triangles, pane->triangles.size() / 4);
  expect_blended();
  while (view->refine()) view->draw();
  view->draw();
  expect_blended();
  const auto picked = view->pick(200, 200);
  ASSERT_TRUE(picked);
  EXPECT_NEAR(picked->z(), 0.03, 1e-4);
}

// Left half opaque, right half with an alpha of 100. With mask and a cutoff of 0.5 it is a hole: what is behind is seen and picked there.
std::shared_ptr<MeshAppearance> make_half_transparent_appearance(const TriangleMesh& mesh, AlphaMode mode, float cutoff) {
  auto appearance =
      make_image_appearance(mesh, make_rgba_png(64, 64, [](int x, int) { return Eigen::Vector4i(255, 0, 0, x < 32 ? 255 : 100); }));
  appearance->materials[0].alpha_mode = mode;
  appearance->materials[0].alpha_cutoff = cutoff;
  return appearance;
}

TEST(PaintedScene, CutsHolesBlendsOrIgnoresTheAlphaOfATexture) {
  const auto wall = make_square(1);
  const auto sheet = move_towards_viewer(*wall, 0.03);
  struct Case {
    AlphaMode mode;
    float cutoff;
    std::array<double, 3> left, right;
    double depth_right;
  };
  const std::array<double, 3> red = {255, 0, 0};
  const std::array<double, 3> green = {0, 255, 0};
  for (const Case& each : {Case{AlphaMode::opaque, 0.5F, red, red, 0.03}, Case{AlphaMode::mask, 0.5F, red, green, 0.0},
                           Case{AlphaMode::mask, 0.3F, red, red, 0.03}, Case{AlphaMode::mask, 1.5F, green, green, 0.0},
                           Case{AlphaMode::blend, 0.5F, red, {100, 155, 0}, 0.03}}) {
    SCOPED_TRACE(testing::Message() << "mode " << int(each.mode) << " cutoff " << each.cutoff);
    const auto view = open_or_fail(
        plain_settings(StereoMode::mono, 400, 400),
        {{sheet, Vec3::Ones(), make_half_transparent_appearance(*sheet, each.mode, each.cutoff)}, {wall, Vec3(0.0, 1.0, 0.0)}});
    ASSERT_TRUE(view);
    view->draw();
    expect_colour(*view, {-0.5 * kHalfSide, 0.0, 0.03}, each.left);
    expect_colour(*view, {0.5 * kHalfSide, 0.0, 0.03}, each.right);
    const Vec2 at = project_to_pixel(view->screen(), Eye::centre, view->picture_size(), Vec3(0.5 * kHalfSide, 0.0, 0.03));
    const auto picked = view->pick(static_cast<int>(at.x()), static_cast<int>(at.y()));
    ASSERT_TRUE(picked);
    EXPECT_NEAR(picked->z(), each.depth_right, 1e-4);
  }
}

// The alpha of the corners is interpolated between the vertices; where it is zero, nothing is hidden.
TEST(PaintedScene, BlendsByTheAlphaOfItsVertices) {
  const auto wall = make_square(1);
  const auto sheet = move_towards_viewer(*wall, 0.03);
  auto appearance = tint(*sheet, {1, 1, 1}, 1.0F);
  for (std::size_t t = 0; t < sheet->triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      appearance->triangles[t].corners[k].alpha = sheet->corner(t, static_cast<int>(k)).x() < 0 ? 0 : 255;
    }
  }
  const auto view =
      open_or_fail(plain_settings(StereoMode::mono, 400, 400), {{sheet, Vec3::Ones(), appearance}, {wall, Vec3(1.0, 0.0, 0.0)}});
  ASSERT_TRUE(view);
  view->draw();
  expect_colour(*view, {-0.5 * kHalfSide, 0.3 * kHalfSide, 0.03}, {255, 64, 64}, 4.0);
  expect_colour(*view, {0.5 * kHalfSide, -0.3 * kHalfSide, 0.03}, {255, 191, 191}, 4.0);
}

// An object whose image cannot be read, and one without an appearance: both have their plain colours.
TEST(PaintedScene, LeavesOtherObjectsAsTheyAre) {
  const auto mesh = make_square(1);
  auto moved = std::make_shared<TriangleMesh>(*mesh);
  for (Vec3& p : moved->vertices) p = 0.4 * p + Vec3(0.0, 0.0, 0.05);
  const auto view =
      open_or_fail(plain_settings(StereoMode::mono, 400, 400),
                   {{mesh, Vec3(0.5, 0.5, 0.5), make_image_appearance(*mesh, "no image at all")}, {moved, Vec3(1.0, 0.5, 0.0)}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  EXPECT_EQ(pixel_at(*view, picture, {0.8 * kHalfSide, 0.8 * kHalfSide, 0}), (std::array{128, 128, 128}));
  EXPECT_EQ(pixel_at(*view, picture, {0.0, 0.0, 0.05}), (std::array{255, 128, 0}));
}

// Draws a grey square under these lights, and returns the colour of its pixel at a point.
std::array<int, 3> colour_under(const std::vector<SceneLight>& lights, const Vec3& at = Vec3::Zero()) {
  ViewSettings settings = plain_settings(StereoMode::mono, 400, 400);
  settings.plain = false;
  settings.depth_cues = false;
  settings.lights = lights;
  const auto view = open_or_fail(settings, {{make_square(40), Vec3(0.5, 0.5, 0.5), nullptr}});
  if (!view) return {};
  view->draw();
  return pixel_at(*view, view->read_picture(), at);
}

// The grey value of a square of 0.5 for this share of light: 0.20 from all sides, and 0.88 times the cosine of the angle of incidence.
int grey(double share) { return static_cast<int>(std::lround(255.0 * 0.5 * share)); }

TEST(PaintedScene, IsLitByTheLightsOfTheScene) {
  const Vec3 aside = Vec3(0.0, std::sqrt(0.75), 0.5);  // 60 degrees: no highlight towards the viewer
  const auto red = colour_under({{.towards_or_p_W = aside, .colour = {1.0, 0.0, 0.0}}});
  EXPECT_NEAR(red[0], grey(0.20 + 0.88 * 0.5), 3);
  EXPECT_NEAR(red[1], grey(0.20), 3);
  EXPECT_NEAR(red[2], grey(0.20), 3);
  // Light from behind does not reach the visible side.
  EXPECT_NEAR(colour_under({{.towards_or_p_W = -aside, .colour = {1.0, 1.0, 1.0}}})[0], grey(0.20), 3);
  // Two add up, each in its colour.
  const auto both =
      colour_under({{.towards_or_p_W = aside, .colour = {0.5, 0.0, 0.0}}, {.towards_or_p_W = aside, .colour = {0.5, 1.0, 0.0}}});
  EXPECT_NEAR(both[0], grey(0.20 + 0.88 * 0.5), 3);
  EXPECT_NEAR(both[1], grey(0.20 + 0.88 * 0.5), 3);
  EXPECT_NEAR(both[2], grey(0.20), 3);
}

TEST(PaintedScene, ALightAtAPlaceShinesFromThere) {
  const SceneLight lamp{.has_position = true, .towards_or_p_W = {0.0, 0.06, 0.02}};
  for (const double y : {0.0, 0.03, -0.05}) {
    const Vec3 from = lamp.towards_or_p_W - Vec3(0.0, y, 0.0);
    const int expected_grey = grey(0.20 + 0.88 * from.normalized().z());
    EXPECT_NEAR(colour_under({lamp}, {0.0, y, 0.0})[0], expected_grey, 8) << y << ": flat shaded in cells of 4 mm";
  }
}

}  // namespace
}  // namespace hapton
