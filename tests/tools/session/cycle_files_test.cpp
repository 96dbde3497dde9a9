#include "tools/session/cycle_files.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "haptic_step/haptics_setup.h"
#include "link/session_codec.h"
#include "recording/cycle_table.h"
#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "tests/recording/made_entries.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

// A recording of many cycles, with a force for every second one and a fault.
std::filesystem::path write_recording(const ScratchFolder& scratch, std::uint64_t samples) {
  SessionCodec session;
  Codec codec;
  std::string bytes(kSessionMagic);
  session.append(SessionHeader{.build = "b1", .start_ns = kCyclesStartNs, .session = 0xAB, .settings = {{"rate", "1000"}}}, bytes);
  std::array<std::byte, kMaxDatagramBytes> wire;
  for (std::uint64_t sample = 1; sample <= samples; ++sample) {
    session.append(cycle_of(sample), bytes);
    if (sample % 2 == 0) {
      auto [entry, datagram] = arrival_of(force_of(sample), sample_ns(sample) + 300'000);
      datagram.header = {.session = 0xAB, .sender = 2, .sequence = sample};
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

TEST(CycleCsv, HasAllColumnsAndLeavesEmptyWhatIsNotKnown) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(write_recording(scratch, 12));
  ASSERT_TRUE(reader) << reader.error().what;
  const auto written = write_cycle_csv(*reader, scratch.path() / "session.csv", kNames);
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

// The haptics node was started before the hub. A program moves an object; one carve was made before the recording began, one during it.
std::filesystem::path write_recording_with_changes(const ScratchFolder& scratch) {
  SessionCodec session;
  Codec codec;
  std::string bytes(kSessionMagic);
  session.append(SessionHeader{.build = "b1", .start_ns = kCyclesStartNs, .session = 0xAB}, bytes);
  std::array<std::byte, kMaxDatagramBytes> wire;
  std::uint64_t sequence = 0;
  const auto receive = [&](const Message& message, std::uint64_t sample) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::received;
    entry.time_ns = sample_ns(sample);
    entry.datagram = std::span(wire).first(codec.encode({{.session = 0xAB, .sender = 2, .sequence = ++sequence}, message}, wire));
    session.append(entry, bytes);
  };
  session.append(cycle_of(1), bytes);
  receive(Carves{.source = 7, .newest = 1}, 1);
  ObjectMove move{.source = 7, .serial = 1, .object = 1, .start_ns = 1'000'000, .end_ns = 2'000'000, .to_p_m = Vec3(0.0, 0.5, 0.0)};
  std::strcpy(move.name.data(), "lid, red");
  receive(move, 2);
  Carves carves{.source = 7, .newest = 2, .first = 1, .count = 2};
  carves.carves[0] = carves.carves[1] = {.object = 0, .to_m = {0.25F, 0.0F, 0.0F}, .radius_m = 0.5F};
  receive(carves, 3);
  ObjectShape part{.source = 7, .serial = 1, .object = 1};
  part.part.total = 2;
  part.part.displacements_m.fill({0.5F, 0.25F, 0.125F});
  receive(part, 3);
  receive(ShapeStart{.source = 7, .serial = 1, .object = 1, .total = 2, .start_ns = 1'000'000, .end_ns = 2'000'000}, 3);
  ForceCommand force = force_of(1);
  force.scene_time_ns = 500'000'000;
  force.carve_serial = 1;
  receive(force, 3);
  session.append(cycle_of(2), bytes);
  return scratch.write("changed.hapton", bytes);
}

TEST(CycleCsv, MovesCarvesAndShapesHaveTheirOwnTables) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(write_recording_with_changes(scratch));
  ASSERT_TRUE(reader && write_cycle_csv(*reader, scratch.path() / "session.csv", kNames));
  const auto lines_of = [&](const char* name) {
    std::ifstream file(scratch.path() / name);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  };
  const std::vector<std::string> moves = lines_of("moves.csv"), carves = lines_of("carves.csv");
  ASSERT_EQ(moves.size(), 2U);
  EXPECT_EQ(moves[0].find("t_s,process,serial,object,start_scene_time_s,"), 0U) << moves[0];
  EXPECT_EQ(moves[1].find("0.002,0,1,1,0.001,0.002,0,0,0,1,0,0,0,0,0.5,0,1,0,0,0,\"lid, red\""), 0U) << moves[1];
  ASSERT_EQ(carves.size(), 3U);
  EXPECT_EQ(carves[1], ",0,1,0,0,0,0,0.25,0,0,0.5,0,0,0,hood") << "when it was made is not known";
  EXPECT_EQ(carves[2], "0.003,0,2,0,0,0,0,0.25,0,0,0.5,0,0,0,hood");
  const std::vector<std::string> shapes = lines_of("shapes.csv");
  ASSERT_EQ(shapes.size(), 2U);
  EXPECT_EQ(shapes[1], "0.003,0,1,1,0,0.001,0.002,2,0,shapes_0_1.npy,glass");
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "shapes_0_1.npy"));
  EXPECT_NE(lines_of("session.csv")[1].find(",0.5,1,glass,hard,"), std::string::npos) << "scene time and carves of sample 1";
}

TEST(CycleCsv, WhereNothingWasMovedThereIsNoFileOfMoves) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(write_recording(scratch, 3));
  ASSERT_TRUE(reader && write_cycle_csv(*reader, scratch.path() / "session.csv"));
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "moves.csv"));
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "carves.csv"));
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "shapes.csv"));
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
  constexpr std::uint64_t kSampleCount = 2 * 4096 + 100;  // two blocks of the file and a part of a third one
  auto reader = SessionReader::open(write_recording(scratch, kSampleCount));
  ASSERT_TRUE(reader) << reader.error().what;
  const auto path = scratch.path() / "session.h5";
  const auto written = write_joined_hdf5(*reader, path, kNames);
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->rows, kSampleCount);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  for (const CycleColumn& column : cycle_columns()) {
    const std::string name = "/samples/" + std::string(column.name);
    EXPECT_EQ(read_column(file, name).size(), kSampleCount) << name;
    EXPECT_EQ(read_text_attribute(file, name, "unit"), column.unit);
  }
  const std::vector<double> samples = read_column(file, "/samples/sample");
  const std::vector<double> wanted_z_n = read_column(file, "/samples/wanted_z_n");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_EQ(samples[i], static_cast<double>(i + 1));
    ASSERT_TRUE(i % 2 == 1 ? wanted_z_n[i] == samples[i] : std::isnan(wanted_z_n[i])) << i;
  }
  for (const char* name : {"/objects/name", "/objects/material"}) {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    const hid_t space = H5Dget_space(set);
    EXPECT_EQ(H5Sget_simple_extent_npoints(space), 2) << name;
    H5Sclose(space);
    H5Dclose(set);
  }
  EXPECT_EQ(read_column(file, "/events/sample"), (std::vector<double>{10, 11, 11}));
  EXPECT_EQ(read_column(file, "/events/t_s")[2], 1e-9 * static_cast<double>(sample_ns(11) - kCyclesStartNs));
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

TEST(JoinedHdf5, HasWhatWasMovedAndCarved) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(write_recording_with_changes(scratch));
  const auto path = scratch.path() / "session.h5";
  ASSERT_TRUE(reader && write_joined_hdf5(*reader, path, kNames));
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  EXPECT_EQ(read_column(file, "/moves/to_y_m"), (std::vector<double>{0.5}));
  EXPECT_EQ(read_texts(file, "/moves/name"), (std::vector<std::string>{"lid, red"}));
  EXPECT_EQ(read_text_attribute(file, "/moves/start_scene_time_s", "unit"), "s");
  EXPECT_EQ(read_column(file, "/carves/serial"), (std::vector<double>{1, 2}));
  EXPECT_TRUE(std::isnan(read_column(file, "/carves/t_s")[0]));
  EXPECT_EQ(read_text_attribute(file, "/carves/radius_m", "unit"), "m");
  EXPECT_EQ(read_column(file, "/shapes/end_scene_time_s"), (std::vector<double>{0.002}));
  EXPECT_EQ(read_column(file, "/shapes/row"), (std::vector<double>{0}));
  EXPECT_EQ(read_column(file, "/shapes/displacements_0_1"), (std::vector<double>{0.5, 0.25, 0.125, 0.5, 0.25, 0.125}));
  EXPECT_EQ(read_text_attribute(file, "/shapes/displacements_0_1", "unit"), "m");
  EXPECT_EQ(read_column(file, "/samples/carve_serial")[0], 1.0);
  EXPECT_TRUE(std::isnan(read_column(file, "/samples/carve_serial")[1])) << "no force came";
  H5Fclose(file);
}

// For each setup the recording has its own haptics node, which replies to one sample and touches object 1.
std::filesystem::path write_recording_of(const ScratchFolder& scratch, const std::vector<HapticsSetup>& setups) {
  SessionCodec session;
  Codec codec;
  std::string bytes(kSessionMagic);
  session.append(SessionHeader{.build = "b1", .start_ns = kCyclesStartNs, .session = 0xAB}, bytes);
  std::array<std::byte, kMaxDatagramBytes> wire;
  std::uint64_t sample = 0;
  for (const HapticsSetup& setup : setups) {
    session.append(cycle_of(++sample), bytes);
    for (const Message& message : {Message(setup), Message(force_of(sample))}) {
      SessionEntry entry;
      entry.kind = SessionEntry::Kind::received;
      entry.time_ns = sample_ns(sample) + 300'000;
      entry.datagram = std::span(wire).first(codec.encode({{.session = 0xAB, .sender = 1 + sample, .sequence = 1}, message}, wire));
      session.append(entry, bytes);
    }
  }
  return scratch.write("haptics.hapton", bytes);
}

TEST(JoinedHdf5, TextsAreWholeHoweverLong) {
  const ScratchFolder scratch;
  const std::string scene = "/home/a/" + std::string(150, 's') + "/scene.toml";
  const std::string method = "name=proxy shading=0.5 probe_radius_m=0.004 coupling_n_per_m=1500";
  const std::string name(60, 'n');
  HapticsSetup setup;
  put_text(scene, setup.scene);
  put_text(method, setup.method);
  auto reader = SessionReader::open(write_recording_of(scratch, {setup}));
  const auto path = scratch.path() / "session.h5";
  const std::vector<ObjectName> names = {{name, "tin"}, {"glass", name}};
  ASSERT_TRUE(reader && write_joined_hdf5(*reader, path, names));
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  EXPECT_EQ(read_texts(file, "/haptics/scene"), (std::vector<std::string>{scene}));
  EXPECT_EQ(read_texts(file, "/haptics/method"), (std::vector<std::string>{method}));
  EXPECT_EQ(read_texts(file, "/objects/name"), (std::vector<std::string>{name, "glass"}));
  EXPECT_EQ(read_texts(file, "/objects/material"), (std::vector<std::string>{"tin", name}));
  H5Fclose(file);
}

// Another node may have another scene, in which the number 1 names another object.
TEST(CycleFiles, NamesAreThoseOfAllHapticsNodesOrOfNone) {
  const ScratchFolder scratch;
  scratch.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  const auto setup_of = [&](const char* file, const std::string& first, const std::string& second) {
    const std::string begin = "[[object]]\nmesh = 'a.obj'\nname = '";
    const auto scene = scratch.write(file, begin + first + "'\n" + begin + second + "'\n");
    return make_haptics_setup(scene, {}, hash_scene(load_scene(scene)->touch_scene()), MethodSettings());
  };
  const HapticsSetup car = setup_of("car.toml", "hood", "lid");
  const HapticsSetup table = setup_of("table.toml", "cup", "saucer");
  for (const bool is_one_scene : {true, false}) {
    const ScratchFolder out;
    const auto recording = write_recording_of(scratch, {car, is_one_scene ? car : table});
    const CommandRun run = run_hapton({"session", "export", recording.string(), "--out", out.path().string(), "--format", "csv"});
    EXPECT_EQ(run.code, 0) << run.err;
    std::ifstream in(out.path() / "session.csv");
    const std::string rows{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(rows.find("lid") != std::string::npos, is_one_scene) << rows;
    EXPECT_EQ(rows.find("saucer"), std::string::npos) << rows;
    EXPECT_EQ(run.err.find("no names of objects: haptics nodes of the recording") != std::string::npos, !is_one_scene) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), is_one_scene ? 0 : 1) << run.err;
  }
}

TEST(CycleFiles, WhereNothingCanBeWrittenOneLineSaysSo) {
  const ScratchFolder scratch;
  const auto recording = write_recording(scratch, 3);
  const auto nowhere = scratch.path() / "no" / "such" / "folder" / "file";
  auto first = SessionReader::open(recording);
  auto second = SessionReader::open(recording);
  for (const auto& written : {write_cycle_csv(*first, nowhere), write_joined_hdf5(*second, nowhere)}) {
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().what.find("cannot be written"), std::string::npos) << written.error().what;
    EXPECT_EQ(written.error().what.find('\n'), std::string::npos);
  }
}

// Whichever write finds the disk full, there is one line and no file, not even a temporary one beside it.
TEST(CycleFiles, OnAFullDiskThereIsOneLineAndNoFile) {
  const ScratchFolder scratch;
  const ScratchFolder out;
  const auto recording = write_recording(scratch, 6'000);
  for (const bool is_hdf5 : {false, true}) {
    const auto path = out.path() / (is_hdf5 ? "session.h5" : "session.csv");
    const auto write = [&] {
      auto reader = SessionReader::open(recording);
      return is_hdf5 ? write_joined_hdf5(*reader, path, kNames) : write_cycle_csv(*reader, path, kNames);
    };
    ASSERT_TRUE(write());
    const auto bytes = std::filesystem::file_size(path);
    std::filesystem::remove(path);
    for (const double share : {0.0, 0.001, 0.01, 0.1, 0.3, 0.6, 0.9, 0.99, 0.9999}) {
      const auto written = [&] {
        const FileSizeLimit full(static_cast<rlim_t>(share * static_cast<double>(bytes)));
        return write();
      }();
      ASSERT_FALSE(written) << path << " of " << bytes << " bytes, limited to " << share;
      EXPECT_EQ(written.error().what.find(path.string() + ": "), 0U) << written.error().what;
      EXPECT_EQ(written.error().what.find('\n'), std::string::npos);
      EXPECT_TRUE(std::filesystem::is_empty(out.path())) << share;
    }
    ASSERT_TRUE(write()) << "nothing stays behind that hinders the next write";
    std::filesystem::remove(path);
  }
}

// If the table of carves cannot be written, the table of samples is not written either.
TEST(CycleCsv, IsWrittenWithAllItsTablesOrNotAtAll) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(write_recording_with_changes(scratch));
  ASSERT_TRUE(reader) << reader.error().what;
  const ScratchFolder out;
  std::filesystem::create_symlink("/dev/full", out.path() / "carves.csv");
  const auto written = write_cycle_csv(*reader, out.path() / "session.csv", kNames);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().what, (out.path() / "carves.csv").string() + ": cannot be written: No space left on device");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(out.path()), {}), 1);
}

// The same for the command itself, in each format.
TEST(CycleFiles, TheCommandFailsOnAFullDisk) {
  const ScratchFolder scratch;
  const auto recording = write_recording(scratch, 6'000);
  for (const char* format : {"tables", "csv", "hdf5", "mcap"}) {
    const ScratchFolder out;
    CommandRun run;
    {
      const FileSizeLimit full(50'000);
      run = run_hapton({"session", "export", recording.string(), "--out", out.path().string(), "--format", format});
    }
    EXPECT_EQ(run.code, 1) << format;
    EXPECT_EQ(run.out, "") << format;
    EXPECT_NE(run.err.find("hapton session export: " + out.path().string()), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_TRUE(std::filesystem::is_empty(out.path())) << format;
  }
}

// Five samples with two gaps (none of them if is_old), and three cycles without a sample, as an older program recorded them.
std::filesystem::path write_gappy_recording(const ScratchFolder& scratch, bool is_old) {
  SessionCodec session;
  std::string bytes(kSessionMagic);
  session.append(SessionHeader{.build = "b1", .start_ns = kCyclesStartNs, .session = 0xAB, .fault = is_old ? "" : "clamped"}, bytes);
  for (const std::uint64_t sample : {1U, 2U, 5U, 6U, 9U}) {
    if (!is_old) session.append(cycle_of(sample), bytes);
  }
  for (const std::uint64_t sample : {10U, 11U, 12U}) {
    SessionEntry old = cycle_of(sample);
    old.cycle.device.reset();
    session.append(old, bytes);
  }
  return scratch.write(is_old ? "old.hapton" : "gappy.hapton", bytes);
}

TEST(CycleFiles, WhatIsMissingInTheRecordingIsCountedAndReported) {
  const ScratchFolder scratch;
  const auto recording = write_gappy_recording(scratch, false);
  auto first = SessionReader::open(recording);
  auto second = SessionReader::open(recording);
  ASSERT_TRUE(first && second);
  for (const auto& written : {write_cycle_csv(*first, scratch.path() / "a.csv"), write_joined_hdf5(*second, scratch.path() / "a.h5")}) {
    ASSERT_TRUE(written) << written.error().what;
    EXPECT_EQ(written->rows, 5U);
    EXPECT_EQ(written->without_sample, 3U);
    EXPECT_EQ(written->lost, 4U);
    EXPECT_EQ(written->gaps, 2U);
  }
  const hid_t file = H5Fopen((scratch.path() / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  EXPECT_EQ(read_text_attribute(file, "/", "fault"), "clamped") << "of a flight record";
  H5Fclose(file);
  for (const char* format : {"csv", "hdf5"}) {
    const ScratchFolder out;
    const CommandRun run = run_hapton({"session", "export", recording.string(), "--out", out.path().string(), "--format", format});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find(": 5 rows\n4 samples in 2 gaps are missing"), std::string::npos) << run.out;
  }
}

TEST(CycleFiles, TheCommandReportsARecordingWithoutSamples) {
  const ScratchFolder scratch;
  const auto recording = write_gappy_recording(scratch, true);
  for (const char* format : {"csv", "hdf5"}) {
    const ScratchFolder out;
    const CommandRun run = run_hapton({"session", "export", recording.string(), "--out", out.path().string(), "--format", format});
    EXPECT_EQ(run.code, 1) << format;
    EXPECT_NE(run.err.find("an older recording"), std::string::npos) << run.err;
    EXPECT_EQ(run.out.find("missing"), std::string::npos) << run.out;
  }
}

}  // namespace
}  // namespace hapton
