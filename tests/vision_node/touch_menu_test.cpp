#include "vision_node/touch_menu.h"

#include <gtest/gtest.h>

#include "vision_node/depth_cues.h"

namespace hapton {
namespace {

using Entry = TouchMenu::Entry;

StereoScreen menu_screen(double yaw_rad, double pitch_rad) {
  Framing framing;
  framing.yaw_rad = yaw_rad;
  framing.pitch_rad = pitch_rad;
  return compute_screen(framing, {1280, 720});
}

TEST(TouchMenu, HangsWithinTheWorkspaceFromWhereverItIsSeen) {
  const Vec3 half = 0.5 * workspace_size_m();
  for (const double yaw : {-3.0, -1.0, -0.4, 0.0, 0.7, 1.57}) {
    for (const double pitch : {-1.5, -0.5, 0.0, 0.35, 1.2}) {
      const StereoScreen screen = menu_screen(yaw, pitch);
      TouchMenu menu;
      EXPECT_FALSE(menu.is_open());
      menu.open(screen, Vec3::Zero());
      ASSERT_TRUE(menu.is_open());
      EXPECT_TRUE(menu.pose().linear().isApprox(screen.X_WV.linear(), 1e-12)) << "upright for the viewer";
      for (const double x : {-0.5, 0.5}) {
        for (const double y : {-0.5, 0.5}) {
          const Vec3 corner = menu.pose() * Vec3(x * TouchMenu::kWidthM, y * TouchMenu::kHeightM, 0.0);
          for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(corner[k]), half[k]) << yaw << " " << pitch;
        }
      }
    }
  }
}

TEST(TouchMenu, TheEntryAtTheTipIsLit) {
  TouchMenu menu;
  menu.open(menu_screen(-0.4, 0.35), Vec3::Zero());
  for (const Entry entry : TouchMenu::kEntries) {
    for (const double depth : {-0.9, 0.0, 0.9}) {
      EXPECT_EQ(menu.receive(menu.pose() * Vec3(place_entry(entry) + Vec3(0.02, 0.0, depth * TouchMenu::kReachM)), 0), std::nullopt);
      EXPECT_EQ(menu.lit(), entry);
    }
  }
  for (const Vec3& beside : {Vec3(0.51 * TouchMenu::kWidthM, 0, 0), Vec3(0, 0.51 * TouchMenu::kHeightM, 0),
                             Vec3(0, -0.51 * TouchMenu::kHeightM, 0), Vec3(0, 0, 1.1 * TouchMenu::kReachM)}) {
    menu.receive(menu.pose() * beside, 0);
    EXPECT_EQ(menu.lit(), std::nullopt);
  }
  menu.receive(Vec3::Constant(std::nan("")), 0);
  EXPECT_EQ(menu.lit(), std::nullopt);
}

TEST(TouchMenu, APressChoosesOnce) {
  TouchMenu menu;
  menu.open(menu_screen(0, 0), Vec3::Zero());
  const Vec3 undo = menu.pose() * place_entry(Entry::undo);
  EXPECT_EQ(menu.receive(undo, 2), std::nullopt) << "down since before it was opened";
  EXPECT_EQ(menu.receive(undo, 0), std::nullopt);
  EXPECT_EQ(menu.receive(undo, 1), Entry::undo);
  EXPECT_EQ(menu.receive(undo, 1), std::nullopt);
  EXPECT_EQ(menu.receive(undo, 3), Entry::undo) << "any button";
  EXPECT_EQ(menu.receive(Vec3(menu.pose() * Vec3(1, 0, 0)), 0), std::nullopt);
  EXPECT_EQ(menu.receive(Vec3(menu.pose() * Vec3(1, 0, 0)), 1), std::nullopt) << "beside it";
}

TEST(TouchMenu, ClosedItDoesNothing) {
  TouchMenu menu;
  EXPECT_EQ(menu.receive(Vec3::Zero(), 0), std::nullopt);
  EXPECT_EQ(menu.receive(Vec3::Zero(), 1), std::nullopt);
  EXPECT_EQ(menu.choose(), std::nullopt);
  EXPECT_EQ(menu.find_ray_point(Vec3::UnitZ(), Vec3::Zero()), std::nullopt);
}

TEST(TouchMenu, ThePointerFindsItWhereItIsSeen) {
  TouchMenu menu;
  const StereoScreen screen = menu_screen(-0.4, 0.35);
  menu.open(screen, Vec3::Zero());
  const Vec3 eye = compute_eye_position(screen, Eye::centre);
  const Vec3 there = menu.pose() * place_entry(Entry::redo);
  const auto found = menu.find_ray_point(eye, eye + 0.3 * (there - eye));
  ASSERT_TRUE(found);
  EXPECT_LE((*found - there).norm(), 1e-12);
  EXPECT_FALSE(menu.find_ray_point(eye, Vec3(menu.pose() * Vec3(0.2, 0, 0))));
  EXPECT_FALSE(menu.find_ray_point(eye, Vec3(eye + (eye - there)))) << "behind the viewer";
}

}  // namespace
}  // namespace hapton
