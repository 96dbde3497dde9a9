#include "tools/session/session_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "tests/recording/made_entries.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/one_line.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

struct ExportTest : testing::Test {
  ScratchFolder scratch;
  std::filesystem::path folder = scratch.path() / "made" / "here";
  SessionExport exported = open();

  SessionExport open() {
    auto opened = SessionExport::open(folder, kCyclesStartNs, {{"lid", ""}, {"a, \"b\"", "clay"}});
    EXPECT_TRUE(opened) << opened.error().what;
    return std::move(*opened);
  }
  void add_sent(std::uint64_t sample) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::sent;
    const Datagram datagram{
        {},
        DeviceState{
            .sample = sample, .sample_time_ns = sample_ns(sample), .p_WD = Vec3(0.5, -0.25, 2.0), .q_WT = Quat(0.5, -0.5, 0.5, -0.5)}};
    exported.add(entry, &datagram);
  }
};

TEST_F(ExportTest, CyclesHaveAllThatWasRecorded) {
  SessionEntry full = cycle_of(3);
  full.cycle.late_ns = 12'345;
  full.cycle.written_n = Vec3(1.0, -2.0, 0.5);
  full.cycle.written_nm = Vec3(0.25, 0.0, -0.125);
  full.cycle.cause = MissCause::device_slow;
  full.cycle.device->p_WD = Vec3(0.25, -0.5, 1.0);
  full.cycle.device->q_WT = Quat(0.5, -0.5, 0.5, -0.5);
  full.cycle.local = CycleLocal{Vec3(0.125, 0.0, -3.0), Vec3::Zero(), 6};
  exported.add(full, nullptr);
  SessionEntry old = cycle_of(4);
  old.cycle.device.reset();
  exported.add(old, nullptr);
  ASSERT_TRUE(exported.close());
  const auto lines = lines_of(folder / "cycles.csv");
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0],
            "t_s,sample,late_us,written_x_n,written_y_n,written_z_n,missed,cause,sample_t_s,x_m,y_m,z_m,qw,qx,qy,qz,buttons,local_x_n,"
            "local_y_n,local_z_n,local_object,written_tx_nm,written_ty_nm,written_tz_nm");
  EXPECT_EQ(lines[1], "0.003200000,3,12.345,1,-2,0.5,2,device slow,0.003000000,0.25,-0.5,1,0.5,-0.5,0.5,-0.5,5,0.125,0,-3,6,0.25,0,-0.125");
  EXPECT_EQ(lines[2], "0.004200000,4,3.000,0,0,0.5,0,none,,,,,,,,,,,,,,0,0,0") << "what was not recorded stays empty";
  EXPECT_EQ(exported.rows().cycles, 2U);
  EXPECT_EQ(exported.rows().trajectory, 1U);
}

// A sample is taken from its datagram or from its cycle, whichever comes first; repeated samples and older ones are left out.
TEST_F(ExportTest, EachSampleIsInTheTrajectoryOnce) {
  add_sent(2);
  exported.add(cycle_of(2), nullptr);
  exported.add(cycle_of(3), nullptr);
  add_sent(3);
  add_sent(1);
  SessionEntry received;
  received.kind = SessionEntry::Kind::received;
  const Datagram datagram{{}, DeviceState{.sample = 9}};
  exported.add(received, &datagram);  // received: not a sample of the hub itself
  ASSERT_TRUE(exported.close());
  EXPECT_EQ(lines_of(folder / "trajectory.csv"),
            (std::vector<std::string>{"t_s,x_m,y_m,z_m,qw,qx,qy,qz,sample", "0.002000000,0.5,-0.25,2,0.5,-0.5,0.5,-0.5,2",
                                      "0.003000000,0.00030000000000000003,0,0.20000000000000001,1,0,0,0,3"}));
  EXPECT_EQ(exported.rows().trajectory, 2U);
}

TEST_F(ExportTest, ForcesHaveTheirRoundTripAndTheNamesOfWhatTheyTouch) {
  ForceCommand force = force_of(5);
  force.force_n = Vec3(0.5, -1.0, 2.0);
  force.visual_offset_m = Vec3(0.25, 0.0, -0.5);
  force.compute_ns = 1500;
  for (const std::int32_t object : {1, -1, 7}) {
    force.object = object;
    force.contact = object >= 0;
    const auto [entry, datagram] = arrival_of(force, sample_ns(5) + 250'125);
    exported.add(entry, &datagram);
  }
  auto [entry, datagram] = arrival_of(force, sample_ns(5));
  entry.kind = SessionEntry::Kind::sent;
  exported.add(entry, &datagram);
  ASSERT_TRUE(exported.close());
  const std::string numbers = "0.005250125,5,0.5,-1,2,";
  const std::string rest = ",0.25,0,-0.5,250.125,1.500,";
  const std::string tool = ",0,0,0,0,0,0,";
  EXPECT_EQ(
      lines_of(folder / "forces.csv"),
      (std::vector<std::string>{"t_s,sample,fx_n,fy_n,fz_n,contact,offset_x_m,offset_y_m,offset_z_m,round_trip_us,compute_us,object,object_"
                                "name,material,tx_nm,ty_nm,tz_nm,turn_x_rad,turn_y_rad,turn_z_rad,haptons",
                                numbers + "1" + rest + "1,\"a, \"\"b\"\"\",clay" + tool, numbers + "0" + rest + ",," + tool,
                                numbers + "1" + rest + "7,," + tool}));
  EXPECT_EQ(exported.rows().forces, 3U);
}

TEST_F(ExportTest, ForcesOfARigidToolHaveItsTorqueItsTurnAndItsHaptons) {
  ForceCommand force = force_of(5);
  force.torque_nm = Vec3(0.5, 0.0, -0.25);
  force.visual_turn = Vec3(0.125, -2.0, 0.0);
  force.haptons = 12;
  const auto [entry, datagram] = arrival_of(force, sample_ns(5));
  exported.add(entry, &datagram);
  ASSERT_TRUE(exported.close());
  EXPECT_TRUE(lines_of(folder / "forces.csv").at(1).ends_with(",0.5,0,-0.25,0.125,-2,0,12")) << lines_of(folder / "forces.csv").at(1);
}

TEST_F(ExportTest, TimesOfAHostileFileDoNoHarm) {
  ForceCommand force = force_of(5);
  force.echo_sample_time_ns = std::numeric_limits<std::int64_t>::max();
  const auto [entry, datagram] = arrival_of(force, std::numeric_limits<std::int64_t>::min());
  exported.add(entry, &datagram);
  SessionEntry cycle = cycle_of(6);
  cycle.cycle.device->time_ns = std::numeric_limits<std::int64_t>::min();
  exported.add(cycle, nullptr);
  ASSERT_TRUE(exported.close());
  const auto forces = lines_of(folder / "forces.csv");
  ASSERT_EQ(forces.size(), 2U);
  EXPECT_EQ(forces[1].substr(0, 23), "-9223372036.854776382,5") << "the earliest time that 64 bits of nanoseconds can hold";
  EXPECT_NE(forces[1].find(",-9223372036854776.000,"), std::string::npos);
  EXPECT_EQ(lines_of(folder / "trajectory.csv").at(1).substr(0, 21), "-9223372036.854776382");
}

TEST_F(ExportTest, AFolderThatCannotBeMadeIsOneLine) {
  const auto file = scratch.write("file", "x");
  const auto opened = SessionExport::open(file / "folder", 0);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("the folder cannot be made"), std::string::npos);
  EXPECT_THAT(opened.error().what, IsOneLine());
}

// Adds a shape as a haptics node announces it: first the vertices, then the start.
void add_shape(SessionExport& to, std::uint32_t serial, std::uint64_t sample, bool is_whole = true) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::received;
  entry.time_ns = sample_ns(sample);
  ObjectShape part{.source = 5, .serial = serial, .object = 1};
  part.part.total = is_whole ? 2 : 100;
  part.part.displacements_m.fill({0.5F, 0.25F, static_cast<float>(serial)});
  const Datagram first{{}, part};
  to.add(entry, &first);
  const Datagram second{{},
                        ShapeStart{.source = 5,
                                   .serial = serial,
                                   .before = serial - 1,
                                   .object = 1,
                                   .total = part.part.total,
                                   .start_ns = 1'500'000'000,
                                   .end_ns = 2'000'000'000}};
  to.add(entry, &second);
}

TEST_F(ExportTest, ShapesHaveARowEachAndTheirVerticesInAnArray) {
  for (std::uint32_t serial = 1; serial <= 2; ++serial) add_shape(exported, serial, 10 * serial);
  add_shape(exported, 3, 40, false);
  ASSERT_TRUE(exported.close());
  EXPECT_EQ(exported.shapes(), 3U);
  const std::string times = ",1.5,2,";
  EXPECT_EQ(lines_of(folder / "shapes.csv"),
            (std::vector<std::string>{"t_s,process,serial,object,before,start_scene_time_s,end_scene_time_s,vertices,row,file,name",
                                      "0.01,0,1,1,0" + times + "2,0,shapes_0_1.npy,\"a, \"\"b\"\"\"",
                                      "0.02,0,2,1,1" + times + "2,1,shapes_0_1.npy,\"a, \"\"b\"\"\"",
                                      "0.04,0,3,1,2" + times + "100,,,\"a, \"\"b\"\"\""}));
  std::ifstream in(folder / "shapes_0_1.npy", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(bytes.size(), 128U + 2 * 2 * 3 * sizeof(float));
  EXPECT_NE(bytes.find("'shape': (2, 2, 3)"), std::string::npos);
  std::array<float, 12> numbers;
  std::memcpy(numbers.data(), bytes.data() + 128, sizeof numbers);
  EXPECT_EQ(numbers, (std::array<float, 12>{0.5F, 0.25F, 1, 0.5F, 0.25F, 1, 0.5F, 0.25F, 2, 0.5F, 0.25F, 2}));
}

TEST_F(ExportTest, WithoutShapesThereIsNoTableAndAnEarlierOneBecomesEmpty) {
  ASSERT_TRUE(exported.close());
  EXPECT_FALSE(std::filesystem::exists(folder / "shapes.csv"));
  SessionExport again = open();
  add_shape(again, 1, 10);
  ASSERT_TRUE(again.close());
  EXPECT_EQ(lines_of(folder / "shapes.csv").size(), 2U);
  SessionExport last = open();
  ASSERT_TRUE(last.close());
  EXPECT_EQ(lines_of(folder / "shapes.csv").size(), 1U);
}

TEST_F(ExportTest, OnAFullDiskThereAreNeitherShapesNorOtherTables) {
  Result<void> closed;
  {
    const FileSizeLimit full(6'000);
    for (std::uint32_t serial = 1; serial <= 400; ++serial) add_shape(exported, serial, serial);
    closed = exported.close();
  }
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().what, (folder / "shapes_0_1.npy").string() + ": cannot be written: File too large");
  { const SessionExport ended = std::move(exported); }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

// The three tables are one result: if one of them cannot be written, no table is kept.
TEST_F(ExportTest, OnAFullDiskThereIsOneLineAndNoTable) {
  Result<void> closed;
  {
    const FileSizeLimit full(6'000);
    for (std::uint64_t sample = 1; sample <= 100; ++sample) exported.add(cycle_of(sample), nullptr);
    closed = exported.close();
  }
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().what, (folder / "trajectory.csv").string() + ": cannot be written: File too large");
  EXPECT_TRUE(exported.rows().cycles == 100 && exported.rows().trajectory == 100);
  { const SessionExport ended = std::move(exported); }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace hapton
