// Objects that are seen from behind, and those that are not.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/vision_node/made_views.h"
#include "vision_node/stereo_view.h"

namespace hapton {
namespace {

TEST(DrawnSide, AnObjectThatShowsItsBacksIsSeenFromBehindWhereOthersAreNot) {
  const auto triangle_at = [](double x) {
    auto back = std::make_shared<TriangleMesh>();
    back->vertices = {{x - 0.03, -0.05, 0.0}, {x + 0.03, -0.05, 0.0}, {x, 0.05, 0.0}};
    back->triangles = {{0, 2, 1}};  // its front faces away from the viewer
    return back;
  };
  auto view =
      open_or_fail(plain_settings(StereoMode::mono, 400, 400),
                   {{.mesh = triangle_at(-0.05), .colour = Vec3(1, 1, 1), .shows_backs = true}, {triangle_at(0.05), Vec3(1, 1, 1)}});
  ASSERT_TRUE(view);
  view->draw();
  const Picture picture = view->read_picture();
  const auto brightness_at = [&](double x) {
    const Vec2 at = project_to_pixel(view->screen(), Eye::centre, view->picture_size(), Vec3(x, -0.02, 0.0));
    return int{*picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()))};
  };
  EXPECT_GT(brightness_at(-0.05), 200);
  EXPECT_LT(brightness_at(0.05), 20);
}

TEST(DrawnSide, OfTwoSheetsBackToBackTheOneThatFacesTheEyeIsSeen) {
  auto front = std::make_shared<TriangleMesh>();
  constexpr std::uint32_t kSheetCells = 16;
  for (std::uint32_t i = 0; i <= kSheetCells; ++i) {
    for (std::uint32_t k = 0; k <= kSheetCells; ++k) {
      const Vec3 p(0.12 * (double(i) / kSheetCells - 0.5), 0.12 * (double(k) / kSheetCells - 0.5), 0.0);
      front->vertices.push_back(p + Vec3(0, 0, 0.02 * std::sin(60.0 * p.x()) * std::cos(50.0 * p.y())));
      if (i == kSheetCells || k == kSheetCells) continue;
      const std::uint32_t a = i * (kSheetCells + 1) + k;
      front->triangles.push_back({a, a + kSheetCells + 1, a + kSheetCells + 2});
      front->triangles.push_back({a, a + kSheetCells + 2, a + 1});
    }
  }
  auto back = std::make_shared<TriangleMesh>(*front);
  for (Triangle& t : back->triangles) std::swap(t[1], t[2]);
  for (const bool is_front_first : {true, false}) {
    std::vector<ShownObject> sheets = {{.mesh = front, .colour = {1, 0, 0}, .shows_backs = true},
                                       {.mesh = back, .colour = {0, 0, 1}, .shows_backs = true}};
    if (!is_front_first) std::swap(sheets[0], sheets[1]);
    auto view = open_or_fail(plain_settings(StereoMode::mono, 400, 400), sheets);
    ASSERT_TRUE(view);
    view->draw();
    const Picture picture = view->read_picture();
    std::size_t red = 0;
    std::size_t blue = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
      red += picture.rgb[i] > 200 ? 1 : 0;
      blue += picture.rgb[i + 2] > 200 ? 1 : 0;
    }
    EXPECT_GT(red, 5'000U) << is_front_first;
    EXPECT_EQ(blue, 0U) << is_front_first;
  }
}

}  // namespace
}  // namespace hapton
