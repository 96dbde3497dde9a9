#include "tools/session/npy_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/file_size_limit.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// Expects the bytes of the format's specification; tests/python reads such files with NumPy.
TEST(NpyFile, HasAHeaderAndTheRows) {
  const ScratchFolder scratch;
  const auto path = scratch.path() / "a.npy";
  auto file = NpyFile::open(path, 2);
  ASSERT_TRUE(file) << file.error().what;
  const std::vector<std::array<float, 3>> row = {{1, 2, 3}, {4, 5, 6.5F}};
  for (int n = 0; n < 3; ++n) file->add(row);
  ASSERT_TRUE(file->close());
  EXPECT_FALSE(std::filesystem::exists(path));
  ASSERT_TRUE(file->keep());
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(bytes.size(), 128U + 3 * 2 * 3 * sizeof(float));
  EXPECT_EQ(bytes.substr(0, 10), std::string("\x93NUMPY\x01\x00v\x00", 10));
  EXPECT_EQ(bytes.substr(10, 66), "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 3), }    ");
  EXPECT_EQ(bytes[127], '\n');
  float last = 0.0F;
  std::memcpy(&last, bytes.data() + bytes.size() - sizeof last, sizeof last);
  EXPECT_EQ(last, 6.5F);
}

TEST(NpyFile, OnAFullDiskThereIsNone) {
  const ScratchFolder scratch;
  const auto path = scratch.path() / "a.npy";
  {
    const FileSizeLimit full(4096);
    auto file = NpyFile::open(path, 1000);
    ASSERT_TRUE(file);
    const std::vector<std::array<float, 3>> row(1000);
    for (int n = 0; n < 10; ++n) file->add(row);
    const auto closed = file->close();
    ASSERT_FALSE(closed);
    EXPECT_NE(closed.error().what.find("a.npy: cannot be written"), std::string::npos) << closed.error().what;
  }
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

}  // namespace
}  // namespace hapton
