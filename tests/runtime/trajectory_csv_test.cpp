#include "runtime/trajectory_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(TrajectoryCsv, PositionsReadBackEqualToTheBit) {
  const std::vector<TrajectoryRow> rows = {{-0.1, Vec3(1.0 / 3.0, -0.0, 1e-300)}, {2.0 / 7.0, Vec3(-5e5, 1e-9, 0.1)}};
  const auto read = parse_trajectory_csv(positions_to_csv(rows), "path.csv");
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ((*read)[i].t_s, rows[i].t_s);
    EXPECT_EQ((*read)[i].p_WD, rows[i].p_WD);
  }
}

// Frame T is that of the stylus (docs/frames.md): q_WT is its orientation in the world.
TEST(TrajectoryCsv, ReadsPositions) {
  const auto rows = parse_trajectory_csv("# made by hand\nt_s,x_m,y_m,z_m\n0,1,2,3\n\n# half way\n0.5, +1e-3 ,-2.5,.25\r\n", "a.csv");
  ASSERT_TRUE(rows) << rows.error().what;
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_EQ((*rows)[0].p_WD, Vec3(1, 2, 3));
  EXPECT_EQ((*rows)[1].t_s, 0.5);
  EXPECT_EQ((*rows)[1].p_WD, Vec3(1e-3, -2.5, 0.25));
  EXPECT_EQ((*rows)[1].q_WT.coeffs(), Quat::Identity().coeffs());
  EXPECT_FALSE((*rows)[1].has_turn);
}

TEST(TrajectoryCsv, ReadsWhatIsFarOutButWithinReach) {
  const auto rows = parse_trajectory_csv("t_s,x_m,y_m,z_m\n-1e9,1e6,-1e6,1e-300\n1e9,0,0,0\n", "a.csv");
  ASSERT_TRUE(rows) << rows.error().what;
  EXPECT_EQ((*rows)[0].p_WD, Vec3(1e6, -1e6, 1e-300));
}

TEST(TrajectoryCsv, ReadsAndNormalisesQuaternions) {
  const auto rows = parse_trajectory_csv("t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,0.6,0.8001,0,0\n", "a.csv");
  ASSERT_TRUE(rows) << rows.error().what;
  EXPECT_NEAR((*rows)[0].q_WT.norm(), 1.0, 1e-15);
  EXPECT_NEAR((*rows)[0].q_WT.w(), 0.6, 1e-3);
  EXPECT_TRUE((*rows)[0].has_turn);
}

// Spreadsheets on Windows begin CSV files with a byte order mark.
TEST(TrajectoryCsv, AByteOrderMarkIsPassedOver) {
  const auto rows = parse_trajectory_csv("\xEF\xBB\xBFt_s,x_m,y_m,z_m\r\n0.5,1,2,3\r\n", "a.csv");
  ASSERT_TRUE(rows) << rows.error().what;
  ASSERT_EQ(rows->size(), 1U);
  EXPECT_EQ(rows->front().p_WD, Vec3(1, 2, 3));
}

TEST(TrajectoryCsv, QuotesNothingThatATerminalWouldObey) {
  const auto rows = parse_trajectory_csv("t_s,x_m,y_m,z_m\n0,1,\x1B[2J" + std::string(50, 'x') + ",3\n", "a.csv");
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().what,
            "a.csv:2: '?[2J" + std::string(36, 'x') + "...' in column y_m is not a finite number; write one like 0.0125");
}

struct BadFile {
  const char* text;
  const char* place;
  const char* reason;
};

TEST(TrajectoryCsv, SaysWhatIsWrongAndWhere) {
  const BadFile cases[] = {
      {"", "a.csv:", "empty"},
      {"# only a comment\n", "a.csv:", "empty"},
      {"t_s,x_m,y_m,z_m\n", "a.csv:", "no rows"},
      {"x,y,z\n", "a.csv:1:", "header"},
      {"t_s,x_m,y_m,z_m,qw\n", "a.csv:1:", "header"},
      {"t_s,x_m,y_m,z_m\n0,1,2\n", "a.csv:2:", "fewer"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3,4\n", "a.csv:2:", "more"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3,\n", "a.csv:2:", "more"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3\n\n1,1,two,3\n", "a.csv:4:", "'two' in column y_m"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3x\n", "a.csv:2:", "z_m"},
      {"t_s,x_m,y_m,z_m\n0,1,,3\n", "a.csv:2:", "y_m"},
      {"t_s,x_m,y_m,z_m\n0,nan,2,3\n", "a.csv:2:", "x_m"},
      {"t_s,x_m,y_m,z_m\n0,1,inf,3\n", "a.csv:2:", "y_m"},
      {"t_s,x_m,y_m,z_m\n0,1,1e999,3\n", "a.csv:2:", "y_m"},
      {"t_s,x_m,y_m,z_m\n0,1e308,2,3\n", "a.csv:2:", "x_m is '1e308', beyond the reach of any device"},
      {"t_s,x_m,y_m,z_m\n0,1,-1000001,3\n", "a.csv:2:", "y_m is '-1000001', beyond the reach of any device"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3\n1,1,2,1.1e6\n", "a.csv:3:", "z_m is '1.1e6', beyond the reach of any device"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3\n1e10,1,2,3\n", "a.csv:3:", "t_s is '1e10'"},
      {"t_s,x_m,y_m,z_m\n0,1,2,3\n0,1,2,3\n", "a.csv:3:", "increase"},
      {"t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n", "a.csv:2:", "length"},
      {"t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,1e300,1e300,0,0\n", "a.csv:2:", "length"},
  };
  for (const BadFile& bad : cases) {
    const auto rows = parse_trajectory_csv(bad.text, "a.csv");
    ASSERT_FALSE(rows) << bad.text;
    EXPECT_THAT(rows.error().what, HasSubstr(bad.place)) << bad.text;
    EXPECT_THAT(rows.error().what, HasSubstr(bad.reason)) << bad.text;
    EXPECT_EQ(rows.error().what.find('\n'), std::string::npos);
  }
}

TEST(TrajectoryCsv, ReadsAFileAndNamesAMissingOne) {
  const std::string path = testing::TempDir() + "trajectory_csv_test.csv";
  std::ofstream(path) << "t_s,x_m,y_m,z_m\n0,1,2,3\n";
  EXPECT_TRUE(read_trajectory_csv(path));
  std::remove(path.c_str());
  const auto missing = read_trajectory_csv(path);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().what, HasSubstr(path));
  EXPECT_FALSE(read_trajectory_csv(testing::TempDir()));
}

// The file is sparse, as the command `truncate` makes it: large, but nearly nothing of it is on the disk. An earlier version read such a
// file until all memory was in use, and was then ended by a signal.
TEST(TrajectoryCsv, AFileThatIsTooLargeIsNotRead) {
  const ScratchFolder folder;
  const auto path = folder.write("huge.csv", "t_s,x_m,y_m,z_m\n0,1,2,3\n");
  std::error_code error;
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40, error);
  if (error) GTEST_SKIP() << "no such file can be made here: " << error.message();
  const auto rows = read_trajectory_csv(path.string());
  ASSERT_FALSE(rows);
  EXPECT_THAT(rows.error().what, HasSubstr("huge.csv: cannot be read: it has 1099511627776 bytes, more than such a file can have"));
}

TEST(TrajectoryCsv, PassesOverTheSampleNumberOfAnExport) {
  const auto rows = parse_trajectory_csv("t_s,x_m,y_m,z_m,qw,qx,qy,qz,sample\n0,1,2,3,1,0,0,0,17\n0.5,1,2,4,1,0,0,0,18\n", "t.csv");
  ASSERT_TRUE(rows) << rows.error().what;
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_EQ((*rows)[1].p_WD, Vec3(1, 2, 4));
  EXPECT_TRUE(parse_trajectory_csv("t_s,x_m,y_m,z_m,sample\n0,1,2,3,17\n", "t.csv"));
  EXPECT_FALSE(parse_trajectory_csv("t_s,x_m,y_m,z_m,sample\n0,1,2,3\n", "t.csv"));
  EXPECT_FALSE(parse_trajectory_csv("t_s,x_m,y_m,z_m,sample\n0,1,2,3,x\n", "t.csv"));
  const auto with_buttons = parse_trajectory_csv("t_s,x_m,y_m,z_m,buttons,sample\n0,1,2,3,5,17\n1,1,2,3,0,18\n", "t.csv");
  ASSERT_TRUE(with_buttons) << with_buttons.error().what;
  EXPECT_EQ(with_buttons->at(0).buttons, 5U);
  EXPECT_EQ(with_buttons->at(1).buttons, 0U);
  EXPECT_TRUE(parse_trajectory_csv("t_s,x_m,y_m,z_m,qw,qx,qy,qz,buttons\n0,1,2,3,1,0,0,0,1\n", "t.csv"));
  for (const char* bad : {"-1", "1.5", "x", "", "4294967296"}) {
    EXPECT_FALSE(parse_trajectory_csv(std::string("t_s,x_m,y_m,z_m,buttons\n0,1,2,3,") + bad + "\n", "t.csv")) << bad;
  }
}

}  // namespace
}  // namespace hapton
