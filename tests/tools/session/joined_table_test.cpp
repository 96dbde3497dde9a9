#include "tools/session/joined_table.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "link/session_codec.h"
#include "tests/support/scratch_folder.h"
#include "tools/session/joined_files.h"

namespace hapton {
namespace {

constexpr std::int64_t kJoinedStartNs = 7'000'000'000;

std::int64_t sample_ns(std::uint64_t sample) { return kJoinedStartNs + static_cast<std::int64_t>(sample) * 1'000'000; }

SessionEntry cycle_of(std::uint64_t sample) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::cycle;
  entry.time_ns = sample_ns(sample) + 200'000;
  entry.cycle = {.sample = sample, .late_ns = 3000, .written_n = Vec3(0.0, 0.0, 0.5), .missed = sample == 3 ? 2U : 0U};
  entry.cycle.device = CycleSample{.time_ns = sample_ns(sample), .p_WD = Vec3(1e-4 * static_cast<double>(sample), 0.0, 0.2), .buttons = 5};
  return entry;
}

ForceCommand force_of(std::uint64_t sample) {
  return {.echo_sample = sample,
          .echo_sample_time_ns = sample_ns(sample),
          .force_n = Vec3(0.0, 0.0, static_cast<double>(sample)),
          .visual_offset_m = Vec3(0.0, 0.0, 1e-3),
          .contact = true,
          .object = 1};
}

std::pair<SessionEntry, Datagram> arrival_of(const ForceCommand& force, std::int64_t time_ns) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::received;
  entry.time_ns = time_ns;
  return {entry, Datagram{{}, force}};
}

struct Joined {
  std::vector<JoinedRow> rows;
  JoinedTable table{kJoinedStartNs, [this](const JoinedRow& row) { rows.push_back(row); }};

  void force(std::uint64_t sample, std::int64_t time_ns) {
    const auto [entry, datagram] = arrival_of(force_of(sample), time_ns);
    table.add(entry, &datagram);
  }
};

TEST(JoinedTable, AForceStandsBesideItsSampleWheneverItCame) {
  Joined joined;
  joined.force(1, sample_ns(1) + 100'000);  // before the cycle is recorded, as on a fast network
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  joined.table.add(cycle_of(3), nullptr);
  joined.force(3, sample_ns(3) + 300'000);
  joined.force(2, sample_ns(3) + 400'000);  // overtaken
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const JoinedRow& row = joined.rows[i];
    EXPECT_EQ(row.sample, i + 1);
    EXPECT_EQ(row.wanted_n.z(), static_cast<double>(i + 1));
    EXPECT_DOUBLE_EQ(row.p_WP.z(), 0.201);
    EXPECT_TRUE(row.is_contact);
    EXPECT_EQ(row.object, 1);
    EXPECT_FALSE(row.is_local);
    EXPECT_EQ(row.buttons, 5U);
  }
  EXPECT_NEAR(joined.rows[0].sample_t_s, 1e-3, 1e-12);
  EXPECT_NEAR(joined.rows[1].v_WD.x(), 0.1, 1e-9);
  EXPECT_NEAR(joined.rows[1].round_trip_s, 1.4e-3, 1e-12);
  EXPECT_EQ(joined.rows[2].missed, 2U);
}

TEST(JoinedTable, ARowWhoseForceNeverComesIsThereWithoutOne) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  joined.force(2, sample_ns(2) + 300'000);
  EXPECT_TRUE(joined.rows.empty()) << "in the order of the samples";
  joined.table.add(cycle_of(6000), nullptr);
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(joined.rows[0].wanted_n.x()));
  EXPECT_TRUE(std::isnan(joined.rows[0].round_trip_s));
  EXPECT_FALSE(joined.rows[0].is_contact);
  joined.table.finish();
  EXPECT_EQ(joined.rows.size(), 3U);
}

TEST(JoinedTable, LocalForcesEventsAndOlderRecordings) {
  Joined joined;
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::clamped;
  joined.table.add(fault, nullptr);
  fault.fault = SessionFault::speed;
  joined.table.add(fault, nullptr);
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 1e-3, 0.0), 6};
  joined.table.add(local, nullptr);
  SessionEntry old = cycle_of(2);
  old.cycle.device.reset();
  joined.table.add(old, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "clamped speed");
  EXPECT_TRUE(joined.rows[0].is_local);
  EXPECT_EQ(joined.rows[0].object, 6);
  EXPECT_TRUE(joined.rows[0].is_contact);
  EXPECT_EQ(joined.rows[0].wanted_n.y(), 2.0);
  EXPECT_DOUBLE_EQ(joined.rows[0].p_WP.y(), 1e-3);
  EXPECT_EQ(joined.table.without_sample(), 1U);
}

TEST(JoinedTable, AGapIsNamedAndCounted) {
  Joined joined;
  for (const std::uint64_t sample : {40U, 41U, 157U, 158U, 158U, 160U}) joined.table.add(cycle_of(sample), nullptr);
  joined.table.finish();
  std::vector<std::uint64_t> lost;
  for (const JoinedRow& row : joined.rows) lost.push_back(row.lost);
  EXPECT_EQ(lost, (std::vector<std::uint64_t>{0, 0, 115, 0, 0, 1})) << "what was before a flight record is no gap";
  EXPECT_EQ(joined.table.lost(), 116U);
  EXPECT_EQ(joined.table.gaps(), 2U);
}

SessionEntry marker_of(std::uint64_t sample, std::string_view text) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::marker;
  entry.time_ns = sample_ns(sample) + 100'000;
  entry.marker = {sample, NodeRole::tool, text};
  return entry;
}

TEST(JoinedTable, AMarkerStandsAtItsSample) {
  Joined joined;
  joined.table.add(marker_of(1, "begin"), nullptr);  // within the cycle, as usual
  joined.table.add(cycle_of(1), nullptr);
  joined.force(1, sample_ns(1) + 250'000);
  joined.table.add(marker_of(1, "after its force"), nullptr);
  joined.table.add(marker_of(2, "of a lost row"), nullptr);
  joined.table.add(cycle_of(4), nullptr);
  joined.table.add(marker_of(5, "at the end"), nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_EQ(joined.rows[0].markers, (std::vector<std::string>{"begin", "after its force"}));
  EXPECT_EQ(joined.rows[1].markers, (std::vector<std::string>{"of a lost row", "at the end"}));
  Joined empty;
  empty.table.add(marker_of(5, "without a row"), nullptr);
  empty.table.finish();
  EXPECT_TRUE(empty.rows.empty());
}

// As `--overrun stop` ends a session: the fault is the last entry.
TEST(JoinedTable, AFaultBehindTheLastCycleIsNotLost) {
  Joined joined;
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{};
  joined.table.add(local, nullptr);
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::overrun;
  joined.table.add(fault, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "overrun");
}

TEST(JoinedTable, TimesOfAHostileFileDoNoHarm) {
  Joined joined;
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    SessionEntry entry = cycle_of(1);
    entry.time_ns = time_ns;
    entry.cycle.device->time_ns = -time_ns / 2;
    joined.table.add(entry, nullptr);
  }
  joined.table.finish();
  EXPECT_EQ(joined.rows.size(), 3U);
}

// A recording of many cycles, with a force for every second one and a fault.
std::filesystem::path write_recording(const ScratchFolder& scratch, std::uint64_t samples) {
  SessionCodec session;
  Codec codec;
  std::string bytes(kSessionMagic);
  session.append(SessionHeader{.build = "b1", .start_ns = kJoinedStartNs, .session = 0xAB, .settings = {{"rate", "1000"}}}, bytes);
  std::array<std::byte, kMaxDatagramBytes> wire;
  for (std::uint64_t sample = 1; sample <= samples; ++sample) {
    session.append(cycle_of(sample), bytes);
    if (sample % 2 == 0) {
      auto [entry, datagram] = arrival_of(force_of(sample), sample_ns(sample) + 300'000);
      datagram.header = {.session = 1, .sender = 2, .sequence = sample};
      entry.datagram = std::span(wire).first(codec.encode(datagram, wire));
      session.append(entry, bytes);
    }
    if (sample == 10) {
      SessionEntry fault;
      fault.kind = SessionEntry::Kind::fault;
      fault.fault = SessionFault::clamped;
      session.append(fault, bytes);
      session.append(marker_of(10,
                               "gez\xC3\xBC"
                               "ckt"),
                     bytes);
      session.append(marker_of(11, "a, b"), bytes);
    }
  }
  return scratch.write("session.hapton", bytes);
}

const std::vector<ObjectName> kNames = {{"hood", "tin"}, {"glass", "hard"}};

TEST(JoinedCsv, HasAllColumnsAndLeavesEmptyWhatIsNotKnown) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(write_recording(scratch, 12));
  ASSERT_TRUE(reader) << reader.error().what;
  const auto written = write_joined_csv(*reader, scratch.path() / "session.csv", kNames);
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->rows, 12U);
  std::ifstream file(scratch.path() / "session.csv");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 13U);
  EXPECT_EQ(lines[0].find("t_s,sample,x_m,y_m,z_m,qw,"), 0U);
  for (const std::string& line : lines)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(lines[0].begin(), lines[0].end(), ',') + (line.find('"') != std::string::npos ? 1 : 0));
  EXPECT_NE(lines[1].find(",,,,,,"), std::string::npos) << "no force came for sample 1: " << lines[1];
  EXPECT_EQ(lines[10].substr(lines[10].rfind(",")),
            ",gez\xC3\xBC"
            "ckt");
  EXPECT_NE(lines[11].find(",clamped,\"a, b\""), std::string::npos) << lines[11];
  EXPECT_NE(lines[0].find(",object_name,material,event,marker"), std::string::npos);
  EXPECT_NE(lines[2].find(",glass,hard,"), std::string::npos) << lines[2];
  EXPECT_EQ(lines[1].find("hood"), std::string::npos);
}

std::vector<double> read_column(hid_t file, const std::string& name) {
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(set);
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
  H5Sclose(space);
  H5Dclose(set);
  return values;
}

std::vector<std::string> read_texts(hid_t file, const std::string& name) {
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(set);
  const hid_t type = H5Dget_type(set);
  std::vector<char*> texts(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  EXPECT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()), 0) << name;
  std::vector<std::string> values(texts.begin(), texts.end());
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, texts.data());
  H5Tclose(type);
  H5Sclose(space);
  H5Dclose(set);
  return values;
}

std::string read_text_attribute(hid_t file, const std::string& object, const std::string& name) {
  const hid_t attribute = H5Aopen_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Aget_type(attribute);
  char* text = nullptr;
  EXPECT_GE(H5Aread(attribute, type, &text), 0) << object << " " << name;
  const std::string value = text != nullptr ? text : "";
  H5free_memory(text);
  H5Tclose(type);
  H5Aclose(attribute);
  return value;
}

TEST(JoinedHdf5, HoldsEverySampleOfEveryBlockWithUnits) {
  const ScratchFolder scratch;
  constexpr std::uint64_t kMany = 2 * 4096 + 100;
  auto reader = SessionReader::open(write_recording(scratch, kMany));
  ASSERT_TRUE(reader) << reader.error().what;
  const auto path = scratch.path() / "session.h5";
  const auto written = write_joined_hdf5(*reader, path, kNames);
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->rows, kMany);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  for (const JoinedColumn& column : joined_columns()) {
    const std::string name = "/samples/" + std::string(column.name);
    EXPECT_EQ(read_column(file, name).size(), kMany) << name;
    EXPECT_EQ(read_text_attribute(file, name, "unit"), column.unit);
  }
  const std::vector<double> samples = read_column(file, "/samples/sample");
  const std::vector<double> wanted = read_column(file, "/samples/wanted_z_n");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_EQ(samples[i], static_cast<double>(i + 1));
    ASSERT_TRUE(i % 2 == 1 ? wanted[i] == samples[i] : std::isnan(wanted[i])) << i;
  }
  for (const char* name : {"/objects/name", "/objects/material"}) {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    const hid_t space = H5Dget_space(set);
    EXPECT_EQ(H5Sget_simple_extent_npoints(space), 2) << name;
    H5Sclose(space);
    H5Dclose(set);
  }
  EXPECT_EQ(read_column(file, "/events/sample"), (std::vector<double>{10, 11, 11}));
  EXPECT_EQ(read_column(file, "/events/t_s")[2], 1e-9 * static_cast<double>(sample_ns(11) - kJoinedStartNs));
  EXPECT_EQ(read_texts(file, "/events/kind"), (std::vector<std::string>{"marker", "fault", "marker"}));
  EXPECT_EQ(read_texts(file, "/events/name"), (std::vector<std::string>{"gez\xC3\xBC"
                                                                        "ckt",
                                                                        "clamped", "a, b"}));
  EXPECT_EQ(read_text_attribute(file, "/", "schema"), "hapton.table/1");
  EXPECT_EQ(read_text_attribute(file, "/", "build"), "b1");
  EXPECT_EQ(read_text_attribute(file, "/", "session"), "00000000000000ab");
  EXPECT_EQ(read_text_attribute(file, "/", "setting rate"), "1000");
  H5Fclose(file);
}

TEST(JoinedFiles, WhereNothingCanBeWrittenOneLineSaysSo) {
  const ScratchFolder scratch;
  const auto recording = write_recording(scratch, 3);
  const auto nowhere = scratch.path() / "no" / "such" / "folder" / "file";
  auto first = SessionReader::open(recording);
  auto second = SessionReader::open(recording);
  for (const auto& written : {write_joined_csv(*first, nowhere), write_joined_hdf5(*second, nowhere)}) {
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().what.find("cannot be written"), std::string::npos) << written.error().what;
    EXPECT_EQ(written.error().what.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace hapton
