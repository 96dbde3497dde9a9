#include "vision_node/stereo_view.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/vision_node/made_views.h"
#include "vision_node/hud_text.h"
#include "vision_node/knob_box.h"

namespace hapton {
namespace {

constexpr double kMarkerRadius = 0.004;
const Vec3 kRed(1, 0, 0);
const Vec3 kGreen(0, 1, 0);
const Vec3 kBlue(0, 0, 1);
const Vec3 kWhite(1, 1, 1);

bool is_same_pixel(const std::uint8_t* a, const std::uint8_t* b) { return std::equal(a, a + 3, b); }

bool is_all_black(const Picture& picture) {
  return std::all_of(picture.rgb.begin(), picture.rgb.end(), [](std::uint8_t byte) { return byte == 0; });
}

// Opens a view, and returns one picture of it.
Picture picture_of(StereoMode mode, int width_px, int height_px, const std::vector<ShownObject>& objects) {
  auto view = open_or_fail(plain_settings(mode, width_px, height_px), objects);
  if (!view) return {{width_px, height_px}, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width_px) * height_px)};
  view->draw();
  return view->read_picture();
}

std::vector<ShownObject> three_markers() {
  return {{make_marker({-0.05, 0.04, 0.08}, kMarkerRadius), kRed},
          {make_marker({0.01, 0.0, 0.0}, kMarkerRadius), kGreen},
          {make_marker({0.05, -0.05, -0.09}, kMarkerRadius), kBlue}};
}
const Vec3 kMarkerCentres[3] = {{-0.05, 0.04, 0.08}, {0.01, 0.0, 0.0}, {0.05, -0.05, -0.09}};

TEST(StereoView, SideBySideShowsEachMarkerWhereTheoryPutsItInEachEye) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), three_markers());
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  ASSERT_EQ(view->picture_size(), (PictureSize{640, 720}));
  const StereoScreen screen = view->screen();
  for (int channel = 0; channel < 3; ++channel) {
    const auto left = centroid(picture, channel, 0, 640);
    const auto right = centroid(picture, channel, 640, 1280);
    ASSERT_TRUE(left && right);
    const Vec2 left_theory = project_to_pixel(screen, Eye::left, {640, 720}, kMarkerCentres[channel]);
    const Vec2 right_theory = project_to_pixel(screen, Eye::right, {640, 720}, kMarkerCentres[channel]);
    EXPECT_LT((*left - left_theory).norm(), 0.6) << "channel " << channel;
    EXPECT_LT((*right - right_theory).norm(), 0.6) << "channel " << channel;
    const double disparity_px = compute_disparity_m(screen, kMarkerCentres[channel].z()) * 640 / screen.width_m;
    EXPECT_NEAR(right->x() - left->x(), disparity_px, 0.6) << "channel " << channel;
    EXPECT_NEAR(right->y() - left->y(), 0.0, 0.6);
  }
  // The disparities are large enough for a test: many pixels, crossed, in front of the screen; none on it; many, uncrossed, behind it.
  EXPECT_LT(compute_disparity_m(screen, 0.08) * 640 / screen.width_m, -15.0);
  EXPECT_EQ(compute_disparity_m(screen, 0.0), 0.0);
  EXPECT_GT(compute_disparity_m(screen, -0.09) * 640 / screen.width_m, 15.0);
}

// The rows [from, to) of a picture, with all columns.
Picture rows_of(const Picture& picture, int from, int to) {
  const std::size_t row = 3 * static_cast<std::size_t>(picture.size.width_px);
  return {{picture.size.width_px, to - from}, {picture.rgb.begin() + from * row, picture.rgb.begin() + to * row}};
}

TEST(StereoView, TopBottomShowsEachMarkerWhereTheoryPutsItAtHalfTheHeight) {
  auto view = open_or_fail(plain_settings(StereoMode::top_bottom, 1280, 720), three_markers());
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  ASSERT_EQ(view->picture_size(), (PictureSize{1280, 360}));
  const StereoScreen screen = compute_screen(plain_settings(StereoMode::top_bottom, 1280, 720).framing, {1280, 720});
  for (int channel = 0; channel < 3; ++channel) {
    const auto above = centroid(rows_of(picture, 360, 720), channel, 0, 1280);
    const auto below = centroid(rows_of(picture, 0, 360), channel, 0, 1280);
    ASSERT_TRUE(above && below);
    const Vec2 half(1.0, 0.5);
    EXPECT_LT((*above - project_to_pixel(screen, Eye::left, {1280, 720}, kMarkerCentres[channel]).cwiseProduct(half)).norm(), 0.6);
    EXPECT_LT((*below - project_to_pixel(screen, Eye::right, {1280, 720}, kMarkerCentres[channel]).cwiseProduct(half)).norm(), 0.6);
  }
}

TEST(StereoView, SideBySideDoesNotSqueeze) {
  const Picture picture = picture_of(StereoMode::side_by_side, 1280, 720, {{make_marker(Vec3::Zero(), 0.03), kWhite}});
  int min_x = 640, max_x = -1, min_y = 720, max_y = -1;
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 640; ++x) {
      if (picture.at(x, y)[0] == 0) continue;
      min_x = std::min(min_x, x);
      max_x = std::max(max_x, x);
      min_y = std::min(min_y, y);
      max_y = std::max(max_y, y);
    }
  }
  ASSERT_GT(max_x - min_x, 100);
  // A ball that is seen a little from the side is drawn a little too wide: by a factor of 1 / cos(3 degrees).
  EXPECT_NEAR(static_cast<double>(max_x - min_x) / (max_y - min_y), 1.0, 0.02);
}

TEST(StereoView, LeftAndRightModesAreTheHalvesOfSideBySide) {
  const Picture both = picture_of(StereoMode::side_by_side, 1280, 720, three_markers());
  const Picture left = picture_of(StereoMode::left, 640, 720, three_markers());
  const Picture right = picture_of(StereoMode::right, 640, 720, three_markers());
  int differing = 0;
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 640; ++x)
      differing += !is_same_pixel(both.at(x, y), left.at(x, y)) + !is_same_pixel(both.at(x + 640, y), right.at(x, y));
  }
  EXPECT_LE(differing, 20) << "of nearly a million pixels; a viewport's offset may round an edge pixel otherwise";
  EXPECT_FALSE(is_all_black(left));
}

TEST(StereoView, MonoIsSeenFromBetweenTheEyes) {
  const Picture mono = picture_of(StereoMode::mono, 640, 720, three_markers());
  const StereoScreen screen = compute_screen(plain_settings(StereoMode::mono, 640, 720).framing, {640, 720});
  for (int channel = 0; channel < 3; ++channel) {
    const auto found = centroid(mono, channel, 0, 640);
    ASSERT_TRUE(found);
    EXPECT_LT((*found - project_to_pixel(screen, Eye::centre, {640, 720}, kMarkerCentres[channel])).norm(), 0.6);
  }
}

// At every pixel where the eyes' pictures differ, the composed picture must show the eye that the pattern gives. Which eye begins depends
// on the window's place on the screen, so either is right, but it must be the same for all pixels.
void expect_pattern(StereoMode mode, int (*pattern)(int x, int y)) {
  const Picture left = picture_of(StereoMode::left, 640, 480, three_markers());
  const Picture right = picture_of(StereoMode::right, 640, 480, three_markers());
  const Picture woven = picture_of(mode, 640, 480, three_markers());
  int as_is = 0, swapped = 0, neither = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const std::uint8_t* l = left.at(x, y);
      const std::uint8_t* r = right.at(x, y);
      const std::uint8_t* w = woven.at(x, y);
      if (is_same_pixel(l, r)) {
        neither += !is_same_pixel(w, l);
        continue;
      }
      const bool is_even = pattern(x, y) % 2 == 0;
      if (is_same_pixel(w, is_even ? l : r))
        ++as_is;
      else if (is_same_pixel(w, is_even ? r : l))
        ++swapped;
      else
        ++neither;
    }
  }
  EXPECT_EQ(neither, 0);
  EXPECT_TRUE((as_is == 0) != (swapped == 0)) << "as is " << as_is << ", swapped " << swapped;
  EXPECT_GT(as_is + swapped, 200);
}

TEST(StereoView, InterlacedTakesRowsInTurn) {
  expect_pattern(StereoMode::interlaced, [](int, int y) { return y; });
}
TEST(StereoView, CheckerboardTakesPixelsInTurn) {
  expect_pattern(StereoMode::checkerboard, [](int x, int y) { return x + y; });
}
TEST(StereoView, DresdenTakesColumnsInTurn) {
  expect_pattern(StereoMode::dresden, [](int x, int) { return x; });
}

// A white marker in front of the screen: the left eye's is in the red channel, the right eye's in the blue one, each where it projects.
void expect_red_left_blue_right(StereoMode mode) {
  const Vec3 p_W(0.02, 0.01, 0.08);
  const Picture picture = picture_of(mode, 640, 480, {{make_marker(p_W, kMarkerRadius), kWhite}});
  const StereoScreen screen = compute_screen(plain_settings(mode, 640, 480).framing, {640, 480});
  const auto red = centroid(picture, 0, 0, 640);
  const auto blue = centroid(picture, 2, 0, 640);
  ASSERT_TRUE(red && blue);
  EXPECT_LT((*red - project_to_pixel(screen, Eye::left, {640, 480}, p_W)).norm(), 0.6);
  EXPECT_LT((*blue - project_to_pixel(screen, Eye::right, {640, 480}, p_W)).norm(), 0.6);
}

TEST(StereoView, RedBlueHasLeftInRedAndRightInBlue) { expect_red_left_blue_right(StereoMode::red_blue); }
TEST(StereoView, AnaglyphHasLeftInRedAndRightInBlue) { expect_red_left_blue_right(StereoMode::anaglyph); }

TEST(StereoView, SplitViewportShowsBothEyesAtHalfWidth) {
  const Vec3 p_W(0.02, 0.01, 0.08);
  const Picture picture = picture_of(StereoMode::split_viewport, 640, 480, {{make_marker(p_W, kMarkerRadius), kWhite}});
  const StereoScreen screen = compute_screen(plain_settings(StereoMode::split_viewport, 640, 480).framing, {640, 480});
  for (const auto& [eye, from] : {std::pair(Eye::left, 0), std::pair(Eye::right, 320)}) {
    const auto found = centroid(picture, 0, from, from + 320);
    ASSERT_TRUE(found);
    const Vec2 theory = project_to_pixel(screen, eye, {640, 480}, p_W);
    EXPECT_NEAR(found->x(), 0.5 * theory.x(), 0.6);
    EXPECT_NEAR(found->y(), theory.y(), 0.6);
  }
}

TEST(StereoView, FakeIsTheLeftEyeAlone) {
  const Picture fake = picture_of(StereoMode::fake, 640, 480, three_markers());
  EXPECT_EQ(fake.rgb, picture_of(StereoMode::left, 640, 480, three_markers()).rgb);
}

TEST(StereoView, EmulateShowsTheEyesInTurn) {
  auto view = open_or_fail(plain_settings(StereoMode::emulate, 640, 480), three_markers());
  ASSERT_TRUE(view);
  std::vector<Picture> shown;
  for (int i = 0; i < 4; ++i) {
    view->draw();
    shown.push_back(view->read_picture());
  }
  const Picture left = picture_of(StereoMode::left, 640, 480, three_markers());
  const Picture right = picture_of(StereoMode::right, 640, 480, three_markers());
  const bool left_first = shown[0].rgb == left.rgb;
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(shown[i].rgb == ((i % 2 == 0) == left_first ? left : right).rgb) << i
                                                                                 << (shown[i].rgb == left.rgb    ? " is left"
                                                                                     : shown[i].rgb == right.rgb ? " is right"
                                                                                                                 : " is neither");
}

TEST(StereoView, EveryModeDrawsSomethingOrSaysWhyNot) {
  for (const std::string& name : stereo_mode_names()) {
    const StereoMode mode = *find_stereo_mode(name);
    auto view = StereoView::open(plain_settings(mode, 320, 240), three_markers());
    if (!view) {
      EXPECT_EQ(mode, StereoMode::crystal_eyes) << name << ": " << view.error().what;
      EXPECT_NE(view.error().what.find("quad-buffered"), std::string::npos);
      EXPECT_EQ(view.error().what.find('\n'), std::string::npos);
      continue;
    }
    (*view)->draw();
    EXPECT_FALSE(is_all_black((*view)->read_picture())) << name;
    if (mode == StereoMode::openxr) {
      EXPECT_EQ((*view)->mode(), StereoMode::mono) << "there is no headset";
    } else if (mode == StereoMode::automatic) {
      const StereoMode chosen = (*view)->mode();
      EXPECT_TRUE(chosen == StereoMode::mono || chosen == StereoMode::crystal_eyes);
    } else {
      EXPECT_EQ((*view)->mode(), mode);
    }
  }
}

TEST(StereoView, TurningTheDialsMovesTheMarkerAsThePoseSays) {
  const Vec3 p_S(0.06, 0.02, 0.0);
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {{make_marker(p_S, kMarkerRadius), kWhite}});
  ASSERT_TRUE(view);
  Dials dials;
  dials.turn(0, 20.0);
  dials.turn(1, 50.0);
  dials.turn(2, -30.0);
  const Pose X_WS = dials.compute_pose(Vec3::Zero());
  view->set_scene_pose(X_WS);
  view->draw();
  const Picture picture = view->read_picture();
  const auto left = centroid(picture, 0, 0, 640);
  const auto right = centroid(picture, 0, 640, 1280);
  ASSERT_TRUE(left && right);
  EXPECT_LT((*left - project_to_pixel(view->screen(), Eye::left, {640, 720}, X_WS * p_S)).norm(), 0.6);
  EXPECT_LT((*right - project_to_pixel(view->screen(), Eye::right, {640, 720}, X_WS * p_S)).norm(), 0.6);
}

TEST(StereoView, CullingHidesTrianglesSeenFromBehind) {
  auto back = std::make_shared<TriangleMesh>();
  back->vertices = {{-0.05, -0.05, 0.0}, {0.05, -0.05, 0.0}, {0.0, 0.05, 0.0}};
  back->triangles = {{0, 2, 1}};  // its front faces away from the viewer
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 640, 360), {{back, kWhite}});
  ASSERT_TRUE(view);
  view->draw();
  EXPECT_TRUE(is_all_black(view->read_picture()));
  view->set_cull(false);
  view->draw();
  EXPECT_FALSE(is_all_black(view->read_picture()));
  view->set_cull(true);
  view->draw();
  EXPECT_TRUE(is_all_black(view->read_picture()));
}

TEST(StereoView, FlatShadingGivesATriangleOneColour) {
  auto bent = std::make_shared<TriangleMesh>();
  bent->vertices = {{-0.05, -0.05, 0.0}, {0.05, -0.05, 0.0}, {0.0, 0.05, 0.0}, {0.1, 0.05, -0.06}};
  bent->triangles = {{0, 1, 2}, {1, 3, 2}};
  ViewSettings settings = plain_settings(StereoMode::mono, 480, 480);
  settings.plain = false;
  auto view = open_or_fail(settings, {{bent, {0.6, 0.6, 0.6}}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  const StereoScreen screen = view->screen();
  const auto colour_at = [&](const Vec3& p_W) {
    const Vec2 pixel = project_to_pixel(screen, Eye::centre, {480, 480}, p_W);
    return picture.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  };
  // Smooth shading would make these differ by tens; specular light, which is not constant over a flat triangle, by a few.
  EXPECT_NEAR(colour_at({-0.03, -0.04, 0.0})[0], colour_at({0.0, 0.03, 0.0})[0], 12);
  const Vec3 other = (bent->vertices[1] + bent->vertices[2] + bent->vertices[3]) / 3.0;
  EXPECT_GT(std::abs(colour_at(other)[0] - colour_at({0.0, 0.0, 0.0})[0]), 15);
}

TEST(StereoView, HudLiesInTheSamePlaceOfBothEyesPictures) {
  ViewSettings settings = plain_settings(StereoMode::side_by_side, 1280, 720);
  settings.plain = false;
  settings.depth_cues = false;  // their pictures differ between the eyes
  auto view = open_or_fail(settings, {});
  ASSERT_TRUE(view);
  view->draw();
  const Picture without = view->read_picture();
  view->set_hud("servo 1000 Hz", "keys");
  view->draw();
  const Picture with = view->read_picture();
  int changed = 0, parallax = 0;
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 640; ++x) {
      changed += !is_same_pixel(with.at(x, y), without.at(x, y));
      parallax += !is_same_pixel(with.at(x, y), with.at(x + 640, y));
    }
  }
  EXPECT_GT(changed, 500);
  EXPECT_EQ(parallax, 0);
}

TEST(StereoView, TheForceBarIsInEveryStereoMode) {
  for (const StereoMode mode : {StereoMode::mono, StereoMode::side_by_side, StereoMode::top_bottom, StereoMode::red_blue,
                                StereoMode::anaglyph, StereoMode::interlaced, StereoMode::dresden, StereoMode::checkerboard,
                                StereoMode::split_viewport, StereoMode::left, StereoMode::right, StereoMode::emulate}) {
    SCOPED_TRACE(stereo_mode_name(mode));
    for (const bool plain : {false, true}) {
      ViewSettings settings = plain_settings(mode, 640, 480);
      settings.plain = plain;
      settings.depth_cues = false;
      auto view = open_or_fail(settings, {});
      ASSERT_TRUE(view);
      ProbeShown probe;
      probe.force_n = {0.0, 4.0, 0.0};
      view->set_probe(probe);
      for (int eyes = 0; eyes < 2; ++eyes) view->draw();  // emulate alternates: two draws give the same eye
      const Picture without = view->read_picture();
      probe.force_limit_n = 8.0;
      view->set_probe(probe);
      for (int eyes = 0; eyes < 2; ++eyes) view->draw();  // emulate alternates: two draws give the same eye
      const Picture with = view->read_picture();
      // The bar may be at the left edge of the window and of each of its halves.
      int left = 0, elsewhere = 0;
      for (int y = 0; y < 480; ++y) {
        for (int x = 0; x < 640; ++x) {
          if (is_same_pixel(with.at(x, y), without.at(x, y))) continue;
          ++(x % 320 < 40 ? left : elsewhere);
        }
      }
      EXPECT_EQ(left > 300, !plain) << left;
      EXPECT_EQ(elsewhere, 0);
    }
  }
}

// One curve has a constant height, the other rises: each has its colour and place, the same in both eyes' pictures. Without curves nothing
// is drawn.
TEST(StereoView, PlotsAreDrawnToScaleAtTheRight) {
  ViewSettings settings = plain_settings(StereoMode::side_by_side, 1280, 720);
  settings.plain = false;
  settings.depth_cues = false;
  auto view = open_or_fail(settings, {});
  ASSERT_TRUE(view);
  view->draw();
  const Picture without = view->read_picture();
  PlotContent flat{"force", {}, 10.0, 7.5}, rising{"age", {}, 10.0, 0.0};
  for (int n = 249; n >= 0; --n) {
    flat.points.push_back({0.02 * n, 2.5});
    rising.points.push_back({0.02 * n, 10.0 - 0.04 * n});
  }
  view->set_plots({flat, rising});
  view->draw();
  const Picture with = view->read_picture();
  int changed_left_of_plots = 0, parallax = 0;
  std::vector<double> green_y, red_y, blue_x, blue_y;
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 640; ++x) {
      const std::uint8_t* p = with.at(x, y);
      parallax += !is_same_pixel(p, with.at(x + 640, y));
      changed_left_of_plots += x < 380 && !is_same_pixel(p, without.at(x, y));
      if (p[1] > p[0] + 80 && p[1] > p[2] + 60) green_y.push_back(y);
      if (p[0] > p[1] + 80 && p[0] > p[2] + 80) red_y.push_back(y);
      if (p[2] > p[0] + 80 && p[1] > p[0] + 50) {
        blue_x.push_back(x);
        blue_y.push_back(y);
      }
    }
  }
  EXPECT_EQ(parallax, 0);
  EXPECT_EQ(changed_left_of_plots, 0);
  ASSERT_TRUE(green_y.size() > 150 && red_y.size() > 150 && blue_x.size() > 150);
  const auto [low_green, high_green] = std::minmax_element(green_y.begin(), green_y.end());
  EXPECT_LE(*high_green - *low_green, 3.0) << "a constant is a level line";
  // A plot is as high as 0.13 of the picture.
  const double limit_above = red_y.front() - green_y.front();
  EXPECT_NEAR(limit_above, 0.5 * 0.13 * 720, 3.0) << "from a quarter of the scale to three quarters";
  const auto [low_blue, high_blue] = std::minmax_element(blue_y.begin(), blue_y.end());
  EXPECT_NEAR(*high_blue - *low_blue, 0.13 * 720, 4.0);
  EXPECT_LT(*high_blue, *low_green) << "the second one is below the first";
  view->set_plots({});
  view->draw();
  EXPECT_EQ(view->read_picture().rgb, without.rgb);
}

TEST(StereoView, PreparingItsShadersLeavesNoProbeInThePicture) {
  ViewSettings settings = plain_settings(StereoMode::mono, 320, 240);
  settings.plain = false;
  auto fresh = open_or_fail(settings, three_markers());
  auto prepared = open_or_fail(settings, three_markers());
  ASSERT_TRUE(fresh && prepared);
  fresh->draw();
  prepared->prepare_shaders();
  prepared->draw();
  EXPECT_EQ(prepared->read_picture().rgb, fresh->read_picture().rgb);
  ProbeShown probe;
  probe.force_n = Vec3(0.0, 5.0, 0.0);
  probe.contact = true;
  for (StereoView* view : {fresh.get(), prepared.get()}) {
    view->set_probe(probe);
    view->draw();
  }
  EXPECT_EQ(prepared->read_picture().rgb, fresh->read_picture().rgb);
}

TEST(StereoView, ANoticeStandsInLargeLettersInTheMiddleOfEachEyesPicture) {
  for (const StereoMode mode : {StereoMode::mono, StereoMode::side_by_side}) {
    ViewSettings settings = plain_settings(mode, 1280, 720);
    settings.plain = false;
    auto view = open_or_fail(settings, {});
    ASSERT_TRUE(view);
    HudFacts facts;
    facts.is_connected = true;
    facts.scene_diameter_m = 1e-4;
    facts.state.status = ProbeStatus::too_small;
    view->set_hud("", "", compose_notice(facts));
    view->draw();
    const Picture picture = view->read_picture();
    const int width = view->picture_size().width_px;
    // Amber letters in the first eye's picture: their leftmost and rightmost pixel, and the number of pixels.
    int left = width, right = 0, letters = 0;
    for (int y = 0; y < 720; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::uint8_t* p = picture.at(x, y);
        if (p[0] < 200 || p[1] < 120 || p[2] > 100) continue;
        ++letters;
        left = std::min(left, x);
        right = std::max(right, x);
      }
    }
    EXPECT_GT(letters, 300);
    EXPECT_GT(left, 0) << "cut off";
    EXPECT_LT(right, width - 1) << "cut off";
    EXPECT_GT(right - left, width / 2);
    EXPECT_NEAR(0.5 * (left + right), 0.5 * width, 0.05 * width);
    view->set_hud("", "", "");
    view->draw();
    const Picture without = view->read_picture();
    EXPECT_NE(picture.rgb, without.rgb);
  }
}

TEST(StereoView, ScreenshotIsAPngOfTheWindow) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 320, 180), three_markers());
  ASSERT_TRUE(view);
  view->draw();
  const auto file = std::filesystem::temp_directory_path() / ("hapton_view_" + std::to_string(getpid()) + ".png");
  ASSERT_TRUE(view->save_png(file));
  std::ifstream in(file, std::ios::binary);
  std::array<unsigned char, 24> head = {};
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  // In the IHDR chunk the width begins at byte 16 and the height at byte 20, both big-endian.
  EXPECT_EQ(head[1], 'P');
  EXPECT_EQ(head[18] * 256 + head[19], 320);
  EXPECT_EQ(head[22] * 256 + head[23], 180);
  std::filesystem::remove(file);
  const auto rejected = view->save_png("/nowhere/at/all.png");
  ASSERT_FALSE(rejected);
  EXPECT_NE(rejected.error().what.find("/nowhere/at/all.png"), std::string::npos);
}

TEST(StereoView, OnScreenWindowDrawsTheSameAsOffScreen) {
  ViewSettings settings = plain_settings(StereoMode::side_by_side, 640, 360);
  settings.offscreen = false;
  auto view = open_or_fail(settings, three_markers());
  ASSERT_TRUE(view);
  view->draw();
  view->poll_events();
  view->take_redraw_request();
  view->draw();
  EXPECT_EQ(view->read_picture().rgb, picture_of(StereoMode::side_by_side, 640, 360, three_markers()).rgb);
}

}  // namespace
}  // namespace hapton
