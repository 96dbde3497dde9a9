#include "io_node/session_recorder.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>
#include <vector>

#include "link/session_reader.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/log_of.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

const std::array<std::byte, 4> kBytes = {std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}};
const Address kPeer = {{1, 2, 3}, 4950};

struct Recorders : testing::Test {
  ScratchFolder scratch;
  SimulatedClock clock{1'000'000'000};
  std::filesystem::path file = scratch.path() / "session.hapton";
  std::filesystem::path flight_folder = scratch.path() / "flight";

  SessionRecorder make(SessionRecorder::Options options) {
    return {std::move(options), {.build = "b", .start_ns = clock.now_ns(), .start_unix_ns = 1'800'000'000'000'000'000}, clock};
  }

  std::vector<SessionEntry> read(const std::filesystem::path& path) {
    auto reader = SessionReader::open(path);
    EXPECT_TRUE(reader) << reader.error().what;
    std::vector<SessionEntry> entries;
    for (SessionEntry entry; reader->next(entry);) {
      EXPECT_TRUE(entry.datagram.empty() || std::equal(kBytes.begin(), kBytes.end(), entry.datagram.begin(), entry.datagram.end()));
      entries.push_back(entry);
    }
    EXPECT_EQ(reader->problem(), "");
    return entries;
  }
  // The flight records that are complete: a name ends in .part while the file is written (runtime/atomic_file.h).
  std::vector<std::filesystem::path> flight_files() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(flight_folder)) {
      const bool is_being_written = entry.path().extension() == ".part";
      if (!is_being_written) files.push_back(entry.path());
    }
    return files;
  }
};

TEST_F(Recorders, WriteAllThatHappensInOrder) {
  auto recorder = make({file, {}});
  ASSERT_TRUE(recorder.start());
  recorder.on_sent(kPeer, kBytes, 5);
  recorder.on_received(kPeer, kBytes, 6);
  recorder.on_cycle({.sample = 17,
                     .late_ns = -3,
                     .written_n = Vec3(1, 2, 3),
                     .written_nm = Vec3(4, 5, 6),
                     .missed = 4,
                     .cause = MissCause::work_long,
                     .device = CycleSample{6, Vec3(0.1, 0.2, 0.3), Quat(0.6, 0, -0.8, 0), 5},
                     .local = CycleLocal{Vec3(4, 5, 6), Vec3(7, 8, 9), 2}},
                    7);
  recorder.on_fault(SessionFault::clamped, 8);
  ASSERT_TRUE(recorder.stop());
  const auto entries = read(file);
  ASSERT_EQ(entries.size(), 4U);
  EXPECT_EQ(entries[0].kind, SessionEntry::Kind::sent);
  EXPECT_EQ(entries[0].peer, kPeer);
  EXPECT_EQ(entries[1].kind, SessionEntry::Kind::received);
  EXPECT_EQ(entries[1].time_ns, 6);
  EXPECT_EQ(entries[2].cycle.sample, 17U);
  EXPECT_EQ(entries[2].cycle.late_ns, -3);
  EXPECT_EQ(entries[2].cycle.written_n, Vec3(1, 2, 3));
  EXPECT_EQ(entries[2].cycle.written_nm, Vec3(4, 5, 6));
  EXPECT_EQ(entries[2].cycle.missed, 4U);
  EXPECT_EQ(entries[2].cycle.cause, MissCause::work_long);
  ASSERT_TRUE(entries[2].cycle.device);
  EXPECT_EQ(entries[2].cycle.device->time_ns, 6);
  EXPECT_EQ(entries[2].cycle.device->p_WD, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(entries[2].cycle.device->q_WT.coeffs(), Quat(0.6, 0, -0.8, 0).coeffs());
  EXPECT_EQ(entries[2].cycle.device->buttons, 5U);
  ASSERT_TRUE(entries[2].cycle.local);
  EXPECT_EQ(entries[2].cycle.local->force_n, Vec3(4, 5, 6));
  EXPECT_EQ(entries[2].cycle.local->visual_offset_m, Vec3(7, 8, 9));
  EXPECT_EQ(entries[2].cycle.local->object, 2);
  EXPECT_EQ(entries[3].fault, SessionFault::clamped);
  EXPECT_EQ(recorder.counts().entries, 4U);
  EXPECT_EQ(recorder.counts().file_entries, 4U);
  EXPECT_EQ(recorder.counts().file_bytes, std::filesystem::file_size(file));
}

TEST_F(Recorders, WithAFullRingCountWhatIsDroppedInsteadOfWaiting) {
  auto recorder = make({.record = file, .ring_bytes = 1024});
  for (int n = 0; n < 100; ++n) recorder.on_sent(kPeer, kBytes, n);  // no thread empties the ring before start()
  ASSERT_TRUE(recorder.start());
  ASSERT_TRUE(recorder.stop());
  const auto entries = read(file);
  EXPECT_GT(recorder.counts().dropped, 50U);
  EXPECT_EQ(entries.size(), 100 - recorder.counts().dropped + 1);
  EXPECT_EQ(entries.back().kind, SessionEntry::Kind::dropped);
  EXPECT_EQ(entries.back().dropped, recorder.counts().dropped);
}

TEST_F(Recorders, KeepMarkersAndSayWhereTheyAre) {
  auto recorder = make({file, {}});
  ASSERT_TRUE(recorder.start());
  const std::string longest(MarkerText::kMaxBytes, 'x');
  EXPECT_EQ(recorder.on_marker({7, NodeRole::vision, "gezückt"}, 8), MarkerStatus::recorded);
  EXPECT_EQ(recorder.on_marker({9, NodeRole::tool, longest}, 10), MarkerStatus::recorded);
  ASSERT_TRUE(recorder.stop());
  auto reader = SessionReader::open(file);
  ASSERT_TRUE(reader);
  SessionEntry entry;
  ASSERT_TRUE(reader->next(entry));
  EXPECT_EQ(entry.kind, SessionEntry::Kind::marker);
  EXPECT_EQ(entry.time_ns, 8);
  EXPECT_EQ(entry.marker.sample, 7U);
  EXPECT_EQ(entry.marker.source, NodeRole::vision);
  EXPECT_EQ(entry.marker.text, "gezückt");
  ASSERT_TRUE(reader->next(entry));
  EXPECT_EQ(entry.marker.text, longest);
  auto flights_only = make({{}, flight_folder});
  EXPECT_EQ(flights_only.on_marker({7, NodeRole::tool, "a"}, 8), MarkerStatus::no_recording);
  auto full = make({.record = file, .ring_bytes = 64});
  EXPECT_EQ(full.on_marker({9, NodeRole::tool, longest}, 10), MarkerStatus::no_room);
}

TEST_F(Recorders, CountSamplesWhoseCycleNeverCame) {
  auto recorder = make({file, {}});
  ASSERT_TRUE(recorder.start());
  for (const std::uint64_t sample : {3U, 4U, 8U, 8U, 5U}) recorder.on_cycle({.sample = sample}, 1);
  ASSERT_TRUE(recorder.stop());
  EXPECT_EQ(recorder.counts().lost_samples, 2U + 3U) << "1 and 2, and 5 to 7";
}

TEST_F(Recorders, UseNoHeapOnTheNetworkThread) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  auto recorder = make({file, flight_folder});
  ASSERT_TRUE(recorder.start());
  AllocationGuard guard;
  for (int n = 0; n < 20'000; ++n) {
    recorder.on_sent(kPeer, kBytes, n * kMs);
    recorder.on_received(kPeer, kBytes, n * kMs);
    recorder.on_cycle({}, n * kMs);
    if (n % 1000 == 0) recorder.on_fault(SessionFault::command_timeout, n * kMs);
  }
  EXPECT_EQ(guard.count(), 0U);
  ASSERT_TRUE(recorder.stop());
}

TEST_F(Recorders, AFaultLeavesTheLastTwoSecondsUnderItsName) {
  auto recorder = make({{}, flight_folder});
  ASSERT_TRUE(recorder.start());
  for (int n = 0; n < 5000; ++n) recorder.on_cycle({.sample = static_cast<std::uint64_t>(n)}, n * kMs);
  recorder.on_fault(SessionFault::command_timeout, 5000 * kMs);
  ASSERT_TRUE(recorder.stop());
  const auto files = flight_files();
  ASSERT_EQ(files.size(), 1U);
  EXPECT_NE(files[0].filename().string().find("-command-timeout.hapton"), std::string::npos) << files[0];
  const auto entries = read(files[0]);
  ASSERT_EQ(entries.size(), 2001U) << "2 s of cycles, and the fault";
  EXPECT_EQ(entries.front().time_ns, 3000 * kMs);
  EXPECT_EQ(entries.back().fault, SessionFault::command_timeout);
  EXPECT_EQ(SessionReader::open(files[0])->header().fault, "command-timeout");
}

TEST_F(Recorders, AFaultIsFollowedForAWhileAndThenWrittenWithoutWaitingForTheEnd) {
  auto recorder = make({{}, flight_folder});
  ASSERT_TRUE(recorder.start());
  const std::int64_t fault_ns = clock.now_ns();
  recorder.on_fault(SessionFault::stalled, fault_ns);
  recorder.on_cycle({}, fault_ns + 100 * kMs);
  clock.advance_ns(SessionRecorder::kAfterFaultNs);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (flight_files().empty() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  ASSERT_EQ(flight_files().size(), 1U);
  EXPECT_EQ(std::filesystem::status(flight_files()[0]).permissions() & std::filesystem::perms::mask,
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write)
      << "only the owner may read what a hand did";
  EXPECT_EQ(read(flight_files()[0]).size(), 2U);
  ASSERT_TRUE(recorder.stop());
}

// Three faults within two seconds, each written before the next one comes: the last record also contains the first fault.
TEST_F(Recorders, ARecordGoesBackTwoSecondsOverWhatWasWrittenBefore) {
  auto recorder = make({{}, flight_folder});
  ASSERT_TRUE(recorder.start());
  const std::int64_t first_ns = clock.now_ns();
  const std::pair<SessionFault, std::int64_t> faults[] = {
      {SessionFault::clamped, first_ns}, {SessionFault::stalled, first_ns + 1900 * kMs}, {SessionFault::device, first_ns + 1950 * kMs}};
  for (std::size_t n = 0; n < std::size(faults); ++n) {
    recorder.on_fault(faults[n].first, faults[n].second);
    clock.advance_ns(faults[n].second + SessionRecorder::kAfterFaultNs - clock.now_ns());
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (flight_files().size() <= n && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  }
  auto files = flight_files();
  ASSERT_EQ(files.size(), std::size(faults));
  const auto entries = read(*std::max_element(files.begin(), files.end()));  // the newest, by its name
  ASSERT_EQ(entries.size(), std::size(faults));
  EXPECT_EQ(entries.front().time_ns, first_ns);
  EXPECT_EQ(entries.back().fault, SessionFault::device);
  ASSERT_TRUE(recorder.stop());
}

TEST_F(Recorders, FlightRecordsAreFew) {
  auto recorder = make({{}, flight_folder});
  ASSERT_TRUE(recorder.start());
  const auto fault_and_wait = [&](std::int64_t time_ns) {
    const auto before = flight_files().size();
    clock.advance_ns(time_ns - clock.now_ns());
    recorder.on_fault(SessionFault::clamped, time_ns);
    clock.advance_ns(SessionRecorder::kAfterFaultNs);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (flight_files().size() == before && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    return flight_files().size() - before;
  };
  EXPECT_EQ(fault_and_wait(clock.now_ns() + kMs), 1U);
  recorder.on_fault(SessionFault::clamped, clock.now_ns());  // the same kind of fault within ten seconds
  for (int n = 1; n < SessionRecorder::kMaxFlights; ++n) ASSERT_EQ(fault_and_wait(clock.now_ns() + SessionRecorder::kFlightEveryNs), 1U);
  recorder.on_fault(SessionFault::device, clock.now_ns());  // one more than a session may have
  ASSERT_TRUE(recorder.stop());
  EXPECT_EQ(recorder.counts().flights, SessionRecorder::kMaxFlights);
  EXPECT_EQ(recorder.counts().flights_left_out, 2);
  EXPECT_EQ(flight_files().size(), static_cast<std::size_t>(SessionRecorder::kMaxFlights));
}

TEST_F(Recorders, AFlightRecordThatCannotBeWrittenIsNotCountedAsWritten) {
  auto recorder = make({{}, flight_folder});
  ASSERT_TRUE(recorder.start());
  std::filesystem::remove_all(flight_folder);
  scratch.write("flight", "a file in place of the folder");
  const std::string log_text = log_of([&] {
    recorder.on_fault(SessionFault::device, clock.now_ns());
    EXPECT_TRUE(recorder.stop());
  });
  EXPECT_EQ(recorder.counts().flights, 0);
  EXPECT_EQ(recorder.counts().flights_left_out, 1);
  EXPECT_NE(log_text.find("device: no flight record: cannot write " + flight_folder.string()), std::string::npos) << log_text;
}

TEST_F(Recorders, AFolderKeepsTheNewestFlightRecordsAndAllOtherFiles) {
  std::filesystem::create_directories(flight_folder);
  for (std::size_t n = 0; n < SessionRecorder::kMaxKeptFlights + 5; ++n) {
    scratch.write(fmt::format("flight/flight-20000101T0000{:02}.000Z-clamped.hapton", n), "old");
  }
  scratch.write("flight/a letter", "mine");
  auto recorder = make({{}, flight_folder});
  ASSERT_TRUE(recorder.start());
  recorder.on_fault(SessionFault::command_timeout, clock.now_ns());
  ASSERT_TRUE(recorder.stop());
  EXPECT_EQ(flight_files().size(), SessionRecorder::kMaxKeptFlights + 1);
  EXPECT_FALSE(std::filesystem::exists(flight_folder / "flight-20000101T000000.000Z-clamped.hapton"));
  EXPECT_TRUE(std::filesystem::exists(flight_folder / "a letter"));
}

TEST_F(Recorders, AFileThatCannotBeWrittenIsAnErrorAtTheStart) {
  auto recorder = make({"/proc/nowhere/session.hapton", {}});
  const auto started = recorder.start();
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().what.find("/proc/nowhere"), std::string::npos);
  EXPECT_NE(started.error().what.find("give another file with --record"), std::string::npos);
  auto other = make({{}, "/proc/nowhere/flight"});
  EXPECT_FALSE(other.start());
  auto unwritable = make({{}, "/proc"});  // this folder exists, but no file can be created in it
  const auto without_flights = unwritable.start();
  ASSERT_FALSE(without_flights);
  EXPECT_NE(without_flights.error().what.find("flight records: /proc cannot be written"), std::string::npos)
      << without_flights.error().what;
}

TEST_F(Recorders, TheFolderOfARecordingIsMade) {
  const std::filesystem::path recording = flight_folder / "deep" / "session.hapton";
  auto recorder = make({recording, {}});
  ASSERT_TRUE(recorder.start());
  ASSERT_TRUE(recorder.stop());
  EXPECT_TRUE(std::filesystem::is_regular_file(recording));
}

TEST_F(Recorders, ADefaultFolderIsMadeWhenThereIsSomethingToWrite) {
  auto recorder = make({.flight_folder = flight_folder, .makes_flight_folder = false});
  ASSERT_TRUE(recorder.start());
  EXPECT_FALSE(std::filesystem::exists(flight_folder));
  recorder.on_fault(SessionFault::device, clock.now_ns());
  ASSERT_TRUE(recorder.stop());
  EXPECT_EQ(flight_files().size(), 1U);
}

// What is recorded cannot be produced again, so a new recording must not overwrite an earlier one.
TEST_F(Recorders, KeepAnEarlierRecordingOfTheSameName) {
  for (const std::uint64_t sample : {1U, 2U, 3U}) {
    auto recorder = make({file, {}});
    ASSERT_TRUE(recorder.start());
    recorder.on_cycle({.sample = sample}, 1);
    ASSERT_TRUE(recorder.stop());
  }
  EXPECT_EQ(read(scratch.path() / "session-1.hapton").at(0).cycle.sample, 1U);
  EXPECT_EQ(read(scratch.path() / "session-2.hapton").at(0).cycle.sample, 2U);
  EXPECT_EQ(read(file).at(0).cycle.sample, 3U);
}

// Two programs that were given the same file: neither recording is lost.
TEST_F(Recorders, RecordOnIntoTheirOwnFileWhenAnotherTakesItsName) {
  auto first = make({file, {}});
  ASSERT_TRUE(first.start());
  first.on_cycle({.sample = 1}, 1);
  auto second = make({file, {}});
  ASSERT_TRUE(second.start());
  first.on_cycle({.sample = 2}, 2);
  second.on_cycle({.sample = 7}, 2);
  ASSERT_TRUE(first.stop());
  ASSERT_TRUE(second.stop());
  EXPECT_EQ(read(scratch.path() / "session-1.hapton").size(), 2U);
  EXPECT_EQ(read(file).size(), 1U);
}

TEST_F(Recorders, CountOnlyWhatIsInTheFileWhenItCannotGrow) {
  auto recorder = make({.record = file, .ring_bytes = SessionRecorder::kRecordRingBytes});
  ASSERT_TRUE(recorder.start());
  for (int n = 1; n <= 20'000; ++n) recorder.on_cycle({.sample = static_cast<std::uint64_t>(n)}, n);
  // No file of this process can grow beyond this size, as on a full disk. Nothing else writes in the meantime.
  constexpr rlim_t kMaxBytes = 300'000;
  rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit lowered = {.rlim_cur = kMaxBytes, .rlim_max = before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &lowered), 0);
  for (int n = 20'001; n <= 40'000; ++n) recorder.on_cycle({.sample = static_cast<std::uint64_t>(n)}, n);
  const auto stopped = recorder.stop();
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);

  EXPECT_FALSE(stopped);
  auto reader = SessionReader::open(file);
  ASSERT_TRUE(reader);
  std::uint64_t readable_entries = 0;
  for (SessionEntry entry; reader->next(entry);) ++readable_entries;
  EXPECT_EQ(recorder.counts().entries + recorder.counts().dropped, 40'000U);
  EXPECT_GT(recorder.counts().file_entries, 0U);
  EXPECT_LE(recorder.counts().file_entries, readable_entries);
  EXPECT_LT(readable_entries, 40'000U);
  EXPECT_LE(recorder.counts().file_bytes, std::filesystem::file_size(file));
  EXPECT_NE(reader->problem(), "");
}

// A killed process leaves the entries that were written so far. A copy made during the recording is such a file.
TEST_F(Recorders, ARecordingOfANodeThatWasKilledHasNoEnd) {
  auto recorder = make({.record = file, .ring_bytes = SessionRecorder::kRecordRingBytes});
  ASSERT_TRUE(recorder.start());
  for (int n = 1; n <= 5000; ++n) recorder.on_cycle({.sample = static_cast<std::uint64_t>(n)}, n);
  const auto copy = scratch.path() / "copy.hapton";
  std::size_t readable_entries = 0;
  for (int tries = 0; tries < 1000 && readable_entries == 0; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
    auto reader = SessionReader::open(copy);
    ASSERT_TRUE(reader) << reader.error().what;
    readable_entries = 0;
    for (SessionEntry entry; reader->next(entry);) ++readable_entries;
    EXPECT_NE(reader->problem(), "");
  }
  EXPECT_GT(readable_entries, 0U);
  ASSERT_TRUE(recorder.stop());
  EXPECT_EQ(read(file).size(), 5000U);
}

TEST_F(Recorders, AFullDiskEndsTheRecordingAndIsReported) {
  auto recorder = make({"/dev/full", {}});
  const auto started = recorder.start();
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().what.find("No space left"), std::string::npos) << started.error().what;
}

}  // namespace
}  // namespace hapton
