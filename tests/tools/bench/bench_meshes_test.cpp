#include "tools/bench/bench_meshes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

TEST(BenchMeshes, AreThoseOfTheFolderHereOrElseOfTheSourceTree) {
  const ScratchFolder scratch;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(scratch.path());
  EXPECT_EQ(find_mesh_folder(), std::filesystem::path(HAPTON_SOURCE_DIR) / "meshes");
  std::filesystem::create_directory("meshes");
  EXPECT_EQ(find_mesh_folder(), "meshes");
  std::filesystem::current_path(before);
}

TEST(BenchMeshes, AreTheMeshFilesOfAFolderInOrder) {
  const ScratchFolder scratch;
  for (const char* name : {"d.stl", "a.txt", "c.obj", "b.ply", "e"}) scratch.write(name, "");
  EXPECT_THAT(find_mesh_files(scratch.path()), testing::ElementsAre("b.ply", "c.obj", "d.stl"));
  EXPECT_THAT(find_mesh_files(scratch.path() / "none"), testing::IsEmpty());
}

}  // namespace
}  // namespace hapton
