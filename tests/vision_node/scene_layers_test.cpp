#include "vision_node/scene_layers.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/decode_image.h"
#include "vision_node/depth_cues.h"
#include "vision_node/knob_box.h"

namespace hapton {
namespace {

std::shared_ptr<const TriangleMesh> bumpy_mesh(std::size_t triangles) {
  return std::make_shared<TriangleMesh>(make_bumpy_sphere(0.07, 0.25, triangles, 1));
}

ViewSettings lit_settings(StereoMode mode, int width_px, int height_px) {
  ViewSettings settings = plain_settings(mode, width_px, height_px);
  settings.plain = false;
  return settings;
}

double share_differing(const Picture& a, const Picture& b, int by_more_than = 0) {
  std::size_t differing = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    int difference = 0;
    for (std::size_t k = 0; k < 3; ++k) difference = std::max(difference, std::abs(int{a.rgb[i + k]} - int{b.rgb[i + k]}));
    differing += difference > by_more_than;
  }
  return static_cast<double>(differing) / (static_cast<double>(a.rgb.size()) / 3.0);
}

TEST(SceneLayers, AMovingProbeDoesNotRedrawTheSceneAndATurnedSceneIsDrawnForEachEye) {
  auto view = open_or_fail(lit_settings(StereoMode::side_by_side, 640, 360), {{bumpy_mesh(1'000), {0.6, 0.6, 0.6}}});
  ASSERT_TRUE(view);
  view->draw();
  EXPECT_EQ(view->scenes_drawn(), 2U);
  const Picture without = view->read_picture();
  ProbeShown probe;
  probe.p_WP = Vec3(0.0, 0.0, 0.1);
  for (int i = 0; i < 5; ++i) {
    probe.p_WP.x() = 0.01 * i;
    view->set_probe(probe);
    view->draw();
  }
  EXPECT_EQ(view->scenes_drawn(), 2U);
  EXPECT_GT(share_differing(view->read_picture(), without), 0.001) << "the probe is there";
  Dials dials;
  dials.turn(1, 10.0);
  view->set_scene_pose(dials.compute_pose(Vec3::Zero()));
  view->draw();
  EXPECT_EQ(view->scenes_drawn(), 4U);
}

TEST(SceneLayers, TheProbeIsHiddenByTheSceneInFrontOfIt) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 320, 320), {{bumpy_mesh(1'000), {1, 0, 0}}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture alone = view->read_picture();
  ProbeShown probe;
  probe.p_WP = Vec3(0.0, 0.0, -0.1);
  probe.q_WT = Quat(Eigen::AngleAxisd(3.14159, Vec3::UnitX()));
  view->set_probe(probe);
  view->draw();
  EXPECT_LT(share_differing(view->read_picture(), alone), 0.002) << "all but what shows through is behind the ball";
}

TEST(SceneLayers, AtRestTheSceneIsDrawnInFullDetailAndAsItWouldBeWithoutLevels) {
  const std::vector<ShownObject> objects = {{bumpy_mesh(300'000), {0.6, 0.6, 0.6}}};
  const ViewSettings settings = lit_settings(StereoMode::mono, 480, 480);
  auto view = open_or_fail(settings, objects);
  ASSERT_TRUE(view);
  wait_for_levels(*view);
  Dials dials;
  dials.turn(1, 20.0);
  view->set_scene_pose(dials.compute_pose(Vec3::Zero()));
  view->draw();
  const Picture moving = view->read_picture();
  EXPECT_LT(view->paint_count().triangles, ScenePainter::kTriangleBudget + 1);
  EXPECT_LT(view->paint_count().largest_error_px, 1.0);
  int parts = 1;
  while (!view->refine() && parts < 100) ++parts;
  EXPECT_GT(parts, 3) << "in parts, not at once";
  view->draw();
  const Picture at_rest = view->read_picture();
  EXPECT_FALSE(view->refine()) << "there is no more to show";

  // The same mesh without levels of detail: in pieces that are too small to get any.
  std::vector<ShownObject> pieces;
  const TriangleMesh& mesh = *objects.front().mesh;
  for (std::size_t from = 0; from < mesh.triangles.size(); from += DetailBuilder::kMinTriangles - 1) {
    auto piece = std::make_shared<TriangleMesh>();
    piece->vertices = mesh.vertices;
    const std::size_t to = std::min(mesh.triangles.size(), from + DetailBuilder::kMinTriangles - 1);
    piece->triangles.assign(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(from),
                            mesh.triangles.begin() + static_cast<std::ptrdiff_t>(to));
    pieces.push_back({piece, {0.6, 0.6, 0.6}});
  }
  auto whole = open_or_fail(settings, pieces);
  ASSERT_TRUE(whole);
  whole->set_scene_pose(dials.compute_pose(Vec3::Zero()));
  whole->draw();
  const Picture reference = whole->read_picture();
  EXPECT_LT(share_differing(at_rest, reference, 3), 0.002);
  EXPECT_GT(share_differing(moving, reference, 3), 0.02) << "otherwise this test checks nothing";
  EXPECT_LT(share_differing(moving, reference, 60), 0.02) << "and a level looks like the mesh";
}

// The graphics driver keeps each level for only one window.
TEST(SceneLayers, LevelsThatBecomeReadyWhileAnotherWindowDrawsBelongToTheirOwnWindow) {
  const std::vector<ShownObject> objects = {{bumpy_mesh(50'000), {0.6, 0.6, 0.6}}};
  const ViewSettings settings = lit_settings(StereoMode::mono, 240, 240);
  auto alone = open_or_fail(settings, objects);
  ASSERT_TRUE(alone);
  wait_for_levels(*alone);
  alone->draw();
  const Picture reference = alone->read_picture();
  auto view = open_or_fail(settings, objects);
  ASSERT_TRUE(view);
  wait_for_levels(*view);
  auto other = open_or_fail(plain_settings(StereoMode::mono, 64, 64), {});
  ASSERT_TRUE(other);
  other->draw();
  ASSERT_TRUE(view->refine());
  view->draw();
  EXPECT_LT(share_differing(view->read_picture(), reference, 3), 0.002);
}

TEST(SceneLayers, AScreenshotIsInFullDetail) {
  auto view = open_or_fail(lit_settings(StereoMode::mono, 240, 240), {{bumpy_mesh(300'000), {0.6, 0.6, 0.6}}});
  ASSERT_TRUE(view);
  wait_for_levels(*view);
  view->draw();
  const auto drawn_before = view->scenes_drawn();
  const auto file = std::filesystem::temp_directory_path() / ("hapton_layers_" + std::to_string(getpid()) + ".png");
  ASSERT_TRUE(view->save_png(file));
  std::filesystem::remove(file);
  EXPECT_GT(view->scenes_drawn(), drawn_before);
  view->draw();
  int parts = 0;
  while (!view->refine() && parts < 100) ++parts;
  EXPECT_LT(parts, 100) << "and the window's own picture is refined again";
}

// Saves a screenshot of the view, and returns it as a picture with rows from the bottom, like read_picture().
Picture screenshot_of(StereoView& view) {
  const auto file = std::filesystem::temp_directory_path() / ("hapton_layers_" + std::to_string(getpid()) + ".png");
  EXPECT_TRUE(view.save_png(file));
  std::ifstream in(file, std::ios::binary);
  const auto texels = decode_image({"screenshot", {std::istreambuf_iterator<char>(in), {}}});
  std::filesystem::remove(file);
  Picture picture;
  if (!texels) {
    ADD_FAILURE() << texels.error().what;
    return picture;
  }
  picture.size = {texels->width, texels->height};
  for (int y = texels->height - 1; y >= 0; --y) {
    for (int x = 0; x < texels->width; ++x) {
      const std::uint8_t* texel = &texels->rgba[4 * (static_cast<std::size_t>(y) * texels->width + x)];
      picture.rgb.insert(picture.rgb.end(), texel, texel + 3);
    }
  }
  return picture;
}

// The window draws one sample for each pixel: each has the marker's or the background's colour. The screenshot mixes them at the edge.
TEST(SceneLayers, AScreenshotHasSmoothEdges) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 240, 240), {{make_marker(Vec3(0.01, 0.02, 0.0), 0.04), {1, 0, 0}}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture window = view->read_picture();
  const Picture screenshot = screenshot_of(*view);
  ASSERT_EQ(screenshot.rgb.size(), window.rgb.size());
  const double differing = share_differing(screenshot, window, 3);
  EXPECT_GT(differing, 0.001) << "along the edge";
  EXPECT_LT(differing, 0.05) << "and nowhere else";
}

// The window's first frame shows only some of the triangles, with holes in place of the others.
TEST(SceneLayers, AScreenshotOfALargeMeshIsInFullDetailFromTheFirstFrameOn) {
  const std::vector<ShownObject> objects = {{bumpy_mesh(1'000'000), {0.6, 0.6, 0.6}}};
  ViewSettings settings = lit_settings(StereoMode::mono, 480, 480);
  settings.depth_cues = false;  // the shadow is cast by a coarse level, so only after that is made
  auto early = open_or_fail(settings, objects);
  ASSERT_TRUE(early);
  early->draw();
  const Picture preview = early->read_picture();
  EXPECT_LT(early->paint_count().triangles, 300'000U) << "otherwise this test checks nothing";
  const Picture at_once = screenshot_of(*early);
  wait_for_levels(*early);
  early->draw();
  const Picture later = screenshot_of(*early);
  ASSERT_EQ(at_once.rgb.size(), later.rgb.size());
  ASSERT_EQ(preview.rgb.size(), later.rgb.size());
  EXPECT_LT(share_differing(at_once, later, 3), 0.002);
  EXPECT_GT(share_differing(preview, later, 3), 0.05);
}

TEST(SceneLayers, PickFindsTheSurfaceUnderAPixelInEitherHalf) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 640, 360), {{make_marker(Vec3(0.02, 0.01, 0.03), 0.02), {1, 0, 0}}});
  ASSERT_TRUE(view);
  view->draw();
  for (const auto& [eye, from] : {std::pair(Eye::left, 0), std::pair(Eye::right, 320)}) {
    const Vec2 pixel = project_to_pixel(view->screen(), eye, {320, 360}, Vec3(0.02, 0.01, 0.03));
    const auto p_W = view->pick(from + static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    ASSERT_TRUE(p_W);
    EXPECT_NEAR((*p_W - Vec3(0.02, 0.01, 0.03)).norm(), 0.02, 0.0005) << "on the ball";
    EXPECT_GT(p_W->z(), 0.045) << "on the side that is seen";
  }
  EXPECT_FALSE(view->pick(2, 2)) << "background";
  EXPECT_FALSE(view->pick(-1, 2));
  EXPECT_FALSE(view->pick(2, 5000));
}

TEST(SceneLayers, AnotherModeOfStereoLooksAsIfItHadBeenOpenedInIt) {
  const std::vector<ShownObject> objects = {{make_marker(Vec3(0.02, 0.01, 0.06), 0.02), {1, 1, 1}}};
  auto view = open_or_fail(plain_settings(StereoMode::mono, 640, 360), objects);
  ASSERT_TRUE(view);
  for (const StereoMode mode : {StereoMode::mono, StereoMode::side_by_side, StereoMode::anaglyph, StereoMode::mono}) {
    ASSERT_TRUE(view->set_stereo(mode));
    EXPECT_EQ(view->mode(), mode);
    view->draw();
    auto opened = open_or_fail(plain_settings(mode, 640, 360), objects);
    ASSERT_TRUE(opened);
    opened->draw();
    EXPECT_EQ(view->read_picture().rgb, opened->read_picture().rgb) << stereo_mode_name(mode);
  }
}

TEST(SceneLayers, SwappedEyesExchangeTheirImages) {
  const std::vector<ShownObject> objects = {{make_marker(Vec3(0.02, 0.01, 0.06), 0.02), {1, 1, 1}}};
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 640, 360), objects);
  ASSERT_TRUE(view);
  view->draw();
  const Picture before = view->read_picture();
  view->swap_eyes();
  view->draw();
  const Picture after = view->read_picture();
  const auto left_before = centroid(before, 0, 0, 320);
  const auto right_before = centroid(before, 0, 320, 640);
  const auto left_after = centroid(after, 0, 0, 320);
  ASSERT_TRUE(left_before && right_before && left_after);
  EXPECT_LT((*left_after - *right_before).norm(), 0.1);
  EXPECT_GT((*left_after - *left_before).norm(), 5.0);
  ASSERT_TRUE(view->set_stereo(StereoMode::anaglyph));
  view->draw();
  const auto red = centroid(view->read_picture(), 0, 0, 640);
  const Vec2 right_eye = project_to_pixel(view->screen(), Eye::right, {640, 360}, Vec3(0.02, 0.01, 0.06));
  ASSERT_TRUE(red);
  EXPECT_LT((*red - right_eye).norm(), 1.5) << "the right eye's picture in red";
}

TEST(SceneLayers, ANearerFramingMakesTheSceneLarger) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 360, 360), {{make_marker(Vec3::Zero(), 0.02), {1, 0, 0}}});
  ASSERT_TRUE(view);
  const auto red_pixels = [&] {
    view->draw();
    const Picture picture = view->read_picture();
    int red = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3) red += picture.rgb[i] > 128;
    return red;
  };
  const int before = red_pixels();
  Framing nearer = plain_settings(StereoMode::mono, 360, 360).framing;
  nearer.view_m *= 0.5;
  view->set_framing(nearer);
  EXPECT_NEAR(red_pixels(), 4.0 * before, 0.05 * 4.0 * before);
}

TEST(SceneLayers, GroundAndWorkspaceAreThereUntilTheyAreLeftOut) {
  ViewSettings settings = lit_settings(StereoMode::mono, 480, 480);
  settings.framing.pitch_rad = 0.4;
  auto view = open_or_fail(settings, {});
  ASSERT_TRUE(view);
  view->draw();
  const Picture with = view->read_picture();
  view->set_depth_cues(false);
  view->draw();
  const double share = share_differing(with, view->read_picture(), 8);
  EXPECT_GT(share, 0.005);
  EXPECT_LT(share, 0.2) << "lines, not areas";
  view->set_depth_cues(true);
  view->draw();
  EXPECT_EQ(share_differing(with, view->read_picture()), 0.0);
}

TEST(SceneLayers, AnObjectDarkensTheGroundInItsShadow) {
  ViewSettings settings = lit_settings(StereoMode::mono, 480, 480);
  settings.framing.pitch_rad = 0.6;
  const Vec3 p_WO(0.0, 0.05, 0.0);
  auto view = open_or_fail(settings, {{make_marker(p_WO, 0.02), {0.8, 0.8, 0.8}}});
  ASSERT_TRUE(view);
  view->draw();
  const Vec2 at = project_to_pixel(view->screen(), Eye::centre, {480, 480}, *find_shadow(p_WO));
  const auto brightness = [&] {
    const Picture picture = view->read_picture();
    const std::uint8_t* rgb = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
    return int{rgb[0]} + rgb[1] + rgb[2];
  };
  const int shaded = brightness();
  view->set_depth_cues(false);
  view->draw();
  EXPECT_LT(shaded, brightness() - 15);
}

TEST(SceneLayers, WhatIsFartherAwayIsHazier) {
  const std::vector<ShownObject> objects = {{make_marker(Vec3(-0.05, 0.0, 0.06), 0.02), {1, 0, 0}},
                                            {make_marker(Vec3(0.05, 0.0, -0.09), 0.02), {1, 0, 0}}};
  auto view = open_or_fail(lit_settings(StereoMode::mono, 480, 480), objects);
  ASSERT_TRUE(view);
  const auto blue_over_red = [&](const Vec3& p_W) {
    const Picture picture = view->read_picture();
    const Vec2 at = project_to_pixel(view->screen(), Eye::centre, {480, 480}, p_W);
    const std::uint8_t* rgb = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
    return static_cast<double>(rgb[2]) / rgb[0];
  };
  view->draw();
  EXPECT_GT(blue_over_red(Vec3(0.05, 0.0, -0.09)), blue_over_red(Vec3(-0.05, 0.0, 0.06)) + 0.02);
}

}  // namespace
}  // namespace hapton
