#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "core/geometry/mesh_measures.h"
#include "runtime/trajectory_csv.h"
#include "scene/touch_mesh.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"
#include "tools/mesh_choice.h"
#include "tools/session/trajectory.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

// Runs `hapton trajectory` for a box of 50 mm: 300 rows, at 500 Hz.
CommandRun make_trajectory_of(const std::string& kind, const std::filesystem::path& out,
                              const std::vector<std::string>& more_arguments = {}) {
  std::vector<std::string> arguments = {"trajectory", "--shape", "box", "--scale-to", "0.05", "--kind", kind,        "--rows",
                                        "300",        "--rate",  "500", "--seed",     "3",    "--out",  out.string()};
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  return run_hapton(arguments);
}

TEST(TrajectoryCommand, AKindIsTheMotionOfItsName) {
  const ScratchFolder folder;
  const TriangleMesh mesh = make_mesh({.file = {}, .unit = {}, .shape = "box", .scale_to_m = 0.05}).value();
  const TrajectorySettings settings{.seed = 3, .rows = 300, .rate_hz = 500.0};
  const std::vector<std::pair<std::string, Result<TouchTrajectory>>> kinds = {{"slide", make_slide_trajectory(mesh, settings)},
                                                                              {"free", make_free_trajectory(mesh, settings)},
                                                                              {"tap", make_tap_trajectory(mesh, settings)},
                                                                              {"walk", make_random_walk(mesh, settings)}};
  for (const auto& [kind, expected] : kinds) {
    SCOPED_TRACE(kind);
    ASSERT_TRUE(expected);
    const auto file = folder.path() / (kind + ".csv");
    const CommandRun run = make_trajectory_of(kind, file);
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("300 rows of " + kind + " over box"));
    const auto rows = read_trajectory_csv(file.string());
    ASSERT_TRUE(rows) << rows.error().what;
    ASSERT_EQ(rows->size(), expected->p_SD.size());
    for (std::size_t i = 0; i < rows->size(); ++i) {
      ASSERT_EQ((*rows)[i].p_WD, expected->p_SD[i]) << i;
      ASSERT_DOUBLE_EQ((*rows)[i].t_s, 0.002 * static_cast<double>(i));
    }
  }
}

TEST(TrajectoryCommand, TheMeshIsWrittenAsItWasFollowed) {
  const ScratchFolder folder;
  const auto mesh_out = folder.path() / "box.ply";
  ASSERT_EQ(make_trajectory_of("tap", folder.path() / "tap.csv", {"--mesh-out", mesh_out.string()}).code, 0);
  const auto loaded = load_touch_mesh(mesh_out, std::nullopt, CrackSealing::off);
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_NEAR(compute_bounds(loaded->mesh).extent(), 0.05, 1e-9);
}

// Without this check the rows would replace the mesh in the same file, without a message.
TEST(TrajectoryCommand, OneFileIsNotBothOutputs) {
  const ScratchFolder folder;
  const CommandRun run = make_trajectory_of("tap", folder.path() / "a.ply", {"--mesh-out", (folder.path() / "b/../a.ply").string()});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("--out and --mesh-out are both"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.ply"));
  const CommandRun blocked = make_trajectory_of("tap", folder.path() / "a.csv", {"--mesh-out", "/proc/a.ply"});
  EXPECT_EQ(blocked.code, 2);
  EXPECT_THAT(blocked.err, HasSubstr("--mesh-out: /proc cannot be written")) << "checked before the work";
}

TEST(TrajectoryCommand, AKindThatDoesNotExistIsAnErrorThatNamesThoseThatDo) {
  const ScratchFolder folder;
  const auto file = folder.path() / "spin.csv";
  const CommandRun run = make_trajectory_of("spin", file);
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("'spin' is not known; known are slide, free, tap, walk"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace hapton
