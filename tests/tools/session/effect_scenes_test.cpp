// The example scenes with effects, through the same steps as `hapton replay`: each material does what its scene file says.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "scene/scene_file.h"
#include "tools/session/replay.h"

namespace hapton {
namespace {

class EffectScene {
 public:
  explicit EffectScene(const char* name) : scene_(load_scene(std::string(HAPTON_SOURCE_DIR "/scenes/") + name)) {
    if (!scene_) ADD_FAILURE() << scene_.error().what;
  }

  const Scene& scene() const { return *scene_; }

  // The middle of the front of an object.
  Vec3 front_of(const std::string& name) const {
    Eigen::AlignedBox3d box;
    for (const SceneObject& object : scene_->objects) {
      if (object.name != name) continue;
      for (const Vec3& v : object.mesh->vertices) box.extend(v);
    }
    EXPECT_FALSE(box.isEmpty()) << name;
    return {box.center().x(), box.center().y(), box.max().z()};
  }

  Replay replay(const std::vector<Vec3>& path, const char* method = "proxy", std::size_t repeat = 1) const {
    const TouchScene touch = scene_->touch_scene();
    auto made = make_method({.name = method}, touch);
    EXPECT_TRUE(made);
    TouchStep step(std::move(*made), touch);
    std::vector<TrajectoryRow> rows;
    for (const Vec3& p : path) rows.push_back({.t_s = 1e-3 * static_cast<double>(rows.size()), .p_WD = p});
    return run_replay(step, rows, {.repeat = repeat}, SteadyClock());
  }

 private:
  Result<Scene> scene_;
};

// A path from 5 mm in front of the surface to `depth` below it, in steps of 10 um.
std::vector<Vec3> press_into(const Vec3& front, double depth) {
  std::vector<Vec3> path;
  for (int k = -500; k <= std::lround(depth * 1e5); ++k) path.push_back(front - Vec3(0, 0, 1e-5 * k));
  return path;
}

std::vector<Vec3> press_and_slide(const Vec3& front, double depth, const Vec3& velocity_m_per_s, int steps) {
  std::vector<Vec3> path = press_into(front, depth);
  const Vec3 start = path.back();
  for (int k = 1; k <= 200; ++k) path.push_back(start);
  for (int k = 1; k <= steps; ++k) path.push_back(start + 1e-3 * k * velocity_m_per_s);
  return path;
}

TEST(BoardScene, HasTwelveMaterialsThatAllGiveAForce) {
  const EffectScene board("board.toml");
  ASSERT_EQ(board.scene().objects.size(), 13U);
  for (const char* method : {"proxy", "smooth", "sweep", "reference"}) {
    for (const SceneObject& object : board.scene().objects) {
      if (object.name == "plate") continue;
      const Vec3 front = board.front_of(object.name);
      std::vector<Vec3> path;
      for (int k = -20; k <= 20; ++k) path.push_back(front + Vec3(0.0007, 0.0003, -1e-4 * k));
      const Replay replay = board.replay(path, method, 2);
      EXPECT_EQ(replay.rows_that_differ, 0U) << object.name << ", " << method;
      EXPECT_EQ(replay.rows.front().force_n, Vec3::Zero()) << object.name << ", " << method;
      EXPECT_GT(replay.rows.back().force_n.z(), 0.05) << object.name << ", " << method;
      EXPECT_LT(replay.rows.back().force_n.norm(), 8.0) << object.name << ", " << method;
    }
  }
}

TEST(BoardScene, FoamGrowsStiffer) {
  const EffectScene board("board.toml");
  const Replay replay = board.replay(press_into(board.front_of("foam"), 0.006));
  for (const double depth : {0.002, 0.004, 0.006}) {
    const auto& row = replay.rows[500 + static_cast<std::size_t>(std::lround(1e5 * depth))];
    EXPECT_NEAR(row.force_n.z(), 80.0 * depth + 2e4 * depth * depth, 1e-6);
  }
}

TEST(BoardScene, OrangePeelPopsAndIsWholeAgainLater) {
  const EffectScene board("board.toml");
  const Vec3 front = board.front_of("orange peel");
  std::vector<Vec3> path = press_into(front, 0.004);
  for (int k = 400; k >= -500; --k) path.push_back(front - Vec3(0, 0, 1e-5 * k));
  const std::vector<Vec3> again = press_into(front, 0.0024);
  path.insert(path.end(), again.begin(), again.end());
  const Replay replay = board.replay(path);
  // A spring of 600 N/m gives way at 1.5 N (2.5 mm). Then only a damping of 3 N s/m is left, at 10 mm/s, inwards and outwards.
  EXPECT_NEAR(replay.rows[500 + 249].force_n.z(), 1.494, 1e-6);
  EXPECT_NEAR(replay.rows[500 + 260].force_n.z(), 0.03, 1e-6);
  EXPECT_NEAR(replay.rows[500 + 400].force_n.z(), 0.03, 1e-6);
  EXPECT_NEAR(replay.rows[500 + 400 + 200].force_n.z(), -0.03, 1e-6) << "drawn back";
  EXPECT_EQ(replay.rows[500 + 400 + 600].force_n, Vec3::Zero());
  EXPECT_NEAR(replay.rows.back().force_n.z(), 600 * 0.0024, 1e-6) << "whole again";
}

TEST(BoardScene, TapeHoldsOn) {
  const EffectScene board("board.toml");
  const Vec3 front = board.front_of("tape");
  std::vector<Vec3> path = press_into(front, 0.001);
  for (int k = 100; k >= -500; --k) path.push_back(front - Vec3(0, 0, 1e-5 * k));
  const Replay replay = board.replay(path);
  const std::size_t at_surface = 500 + 100 + 1 + 100;
  EXPECT_NEAR(replay.rows[at_surface + 200].force_n.z(), -300 * 0.002, 1e-6);
  EXPECT_NEAR(replay.rows[at_surface + 399].force_n.z(), -300 * 0.00399, 1e-6);
  EXPECT_EQ(replay.rows[at_surface + 410].force_n, Vec3::Zero()) << "released";
}

TEST(BoardScene, HoneyDragsWithTheSpeed) {
  const EffectScene board("board.toml");
  for (const double speed : {0.01, 0.05}) {
    const Replay replay = board.replay(press_and_slide(board.front_of("honey"), 0.003, {speed, 0, 0}, 200));
    EXPECT_NEAR(replay.rows.back().force_n.x(), -8.0 * speed, 1e-6);
    EXPECT_NEAR(replay.rows.back().force_n.z(), 0.9, 1e-6);
  }
}

TEST(BoardScene, CorduroyPushesSidewaysWithItsPeriod) {
  const EffectScene board("board.toml");
  const Vec3 front = board.front_of("corduroy");
  const Replay replay = board.replay(press_and_slide(front, 0.003, {0.04, 0, 0}, 400));
  for (int k = 0; k <= 400; k += 7) {
    const auto& row = replay.rows[replay.rows.size() - 401 + k];
    const double phase_rad = 2.0 * std::numbers::pi * row.p_WD.x() / 0.005;
    const double pressed_m = 0.003 - 0.0002 * (1.0 - std::cos(phase_rad));
    EXPECT_NEAR(row.force_n.z(), 600 * pressed_m, 1e-5) << k;
    EXPECT_NEAR(row.force_n.x(), 600 * pressed_m * 0.0002 * 2.0 * std::numbers::pi / 0.005 * std::sin(phase_rad), 1e-5) << k;
  }
}

// The probe goes down into the gap between two tiles, onto the plate, and sideways. Only for methods that follow the surface itself.
TEST(BoardScene, NothingSlipsUnderATile) {
  const EffectScene board("board.toml");
  const double wood_left_m = board.front_of("wood").x() - 0.028;
  for (const char* method : {"proxy", "reference"}) {
    std::vector<Vec3> path;
    for (int k = 0; k <= 200; ++k) path.push_back(Vec3(wood_left_m - 0.003, board.front_of("wood").y(), 0.0115 - 7e-5 * k));
    for (int k = 1; k <= 600; ++k) path.push_back(path[200] + Vec3(1e-5 * k, 0, 0));
    const Replay replay = board.replay(path, method);
    EXPECT_NEAR(replay.rows.back().p_WD.x(), wood_left_m + 0.003, 1e-9);
    EXPECT_LT(replay.rows.back().force_n.x(), -2.5) << method << ": 3 mm at 1,000 N/m";
    for (std::size_t n = 500; n < replay.rows.size(); ++n) {
      EXPECT_LT((replay.rows[n].force_n - replay.rows[n - 1].force_n).norm(), 0.1) << method << ", step " << n;
    }
  }
}

TEST(BoardScene, SteelRingsWhenTapped) {
  const EffectScene board("board.toml");
  const Vec3 front = board.front_of("steel");
  std::vector<Vec3> path;
  for (int k = 0; k < 20; ++k) path.push_back(front + Vec3(0, 0, 0.001 * (19.5 - k)));  // at 1 m/s, down to 0.5 mm above the front
  path.push_back(front - Vec3(0, 0, 0.0005));
  for (int k = 0; k < 60; ++k) path.push_back(front - Vec3(0, 0, 0.0005));
  const Replay replay = board.replay(path);
  for (int k = 0; k <= 60; ++k) {
    // 1,000 N/m at a depth of 0.5 mm; the tap adds 6 N s/m at 1 m/s, but at most 2 N.
    const double t = 1e-3 * k;
    EXPECT_NEAR(replay.rows[20 + k].force_n.z(), 0.5 + 2.0 * std::exp(-t / 0.06) * std::sin(2.0 * std::numbers::pi * 300 * t), 1e-6) << k;
  }
}

TEST(NeedleScene, SkinAndMuscleGiveWayAndBoneHolds) {
  const EffectScene needle("needle.toml");
  const Vec3 front = needle.front_of("tissue");
  const Replay replay = needle.replay(press_into(front, 0.034));
  const auto row_at = [&](double depth) { return replay.rows[500 + static_cast<std::size_t>(std::lround(1e5 * depth))]; };
  const double water_n = 0.5 * 0.01;  // damping of 0.5 N s/m, at 10 mm/s
  EXPECT_NEAR(row_at(0.0029).force_n.z(), 400 * 0.0029 + water_n, 1e-6);
  EXPECT_NEAR(row_at(0.0032).force_n.z(), 2.0 * 0.01 + water_n, 1e-6) << "through the skin: the damping of fat";
  EXPECT_NEAR(row_at(0.0130).force_n.z(), 600 * 0.003 + 0.02 + water_n, 1e-6) << "on the muscle";
  EXPECT_NEAR(row_at(0.0200).force_n.z(), 6.0 * 0.01 + water_n, 1e-6) << "through it";
  EXPECT_NEAR(row_at(0.0330).force_n.z(), 1000 * 0.003 + 0.06 + water_n, 1e-6) << "on the bone";
  EXPECT_NEAR(row_at(0.0320).p_WP.z(), front.z() - 0.030, 1e-9) << "the tip is drawn on the bone";
  EXPECT_NEAR(row_at(0.0200).p_WP.z(), front.z() - 0.020, 1e-9) << "in the tissue it is drawn where the device is";
}

TEST(NeedleScene, TheMagnetPulls) {
  const EffectScene needle("needle.toml");
  std::vector<Vec3> path(50, Vec3(-0.10, 0.0, 0.06) + Vec3(0.0075, 0, 0));
  const Replay replay = needle.replay(path);
  EXPECT_LT((replay.rows.back().force_n - Vec3(-1.0, 0, 0)).norm(), 1e-9) << "largest at half its range";
}

}  // namespace
}  // namespace hapton
