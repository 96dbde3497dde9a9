#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "io_node/servo_tap.h"
#include "link/session_codec.h"
#include "runtime/byte_ring.h"
#include "runtime/clock.h"

namespace hapton {

// Records everything that device side and network side do, at full rate, in its own thread: the whole session in one file and, after a
// fault, the last two seconds in a flight record named after the fault. The network side only copies into a ring; entries that do not fit
// are dropped and counted, also in the file. Flight records are limited: one for each kind of fault in kFlightEveryNs, and kMaxFlights in a
// session; the folder keeps the newest kMaxKeptFlights. Units: ns of the hub's clock. RT: the on_ functions yes, wait-free; the rest set-up
// only. Threads: the on_ functions and is_recording: that of the network side; the others: one other thread.
class SessionRecorder final : public ServoTap {
 public:
  static constexpr std::int64_t kFlightNs = 2 * kNanosecondsPerSecond;
  static constexpr std::int64_t kAfterFaultNs = kNanosecondsPerSecond / 4;  // a flight record also has this much after the fault; a choice
  // These limit the disk space that a repeating fault, or many sessions, can take up. Choices.
  static constexpr std::int64_t kFlightEveryNs = 10 * kNanosecondsPerSecond;
  static constexpr int kMaxFlights = 16;
  static constexpr std::size_t kMaxKeptFlights = 64;
  static constexpr std::size_t kRingBytes = std::size_t{1} << 22;        // 0.5 s at 10 kHz: enough for flight records
  static constexpr std::size_t kRecordRingBytes = std::size_t{1} << 24;  // 2 s at 10 kHz: a recording should have every sample

  struct Options {
    std::filesystem::path record = {};         // empty: no file of the whole session
    std::filesystem::path flight_folder = {};  // empty: no flight records
    std::size_t ring_bytes = kRingBytes;
    // start() makes the folder, so that a failure is reported early; false: the first flight record makes it.
    bool makes_flight_folder = true;
  };
  struct Counts {
    std::uint64_t entries = 0;  // entries that reached the writing thread
    std::uint64_t dropped = 0;
    std::uint64_t lost_samples = 0;  // device samples whose cycle did not reach the writing thread
    std::uint64_t file_entries = 0;  // complete in the recording: all, or at least those before its disk was full
    std::uint64_t file_bytes = 0;
    int flights = 0;
    int flights_left_out = 0;  // faults with no record of their own, because of the limits above or the disk
  };

  // header: written at the start of each file. Pre: clock outlives this.
  SessionRecorder(Options options, SessionHeader header, const Clock& clock);
  ~SessionRecorder() override;

  // Opens the file and starts the thread. An existing file of the same name is renamed first (runtime/earlier_file.h), and the log has its
  // new name. Error: the file or the flight folder cannot be written.
  Result<void> start();
  // Writes what is left, then ends the thread. Error: the file could not be written to its end.
  Result<void> stop();
  // Pre: stop() has returned.
  const Counts& counts() const { return counts_; }

  void on_received(const Address& from, std::span<const std::byte> datagram, std::int64_t time_ns) noexcept override;
  void on_sent(const Address& to, std::span<const std::byte> datagram, std::int64_t time_ns) noexcept override;
  void on_cycle(const CycleNote& note, std::int64_t time_ns) noexcept override;
  void on_fault(SessionFault fault, std::int64_t time_ns) noexcept override;
  bool is_recording() const noexcept override { return records_all_; }
  MarkerStatus on_marker(const MarkerNote& note, std::int64_t time_ns) noexcept override;

 private:
  // A block drained from the ring, unchanged.
  struct Block {
    std::vector<std::byte> bytes;
    std::int64_t newest_ns = 0;
  };
  struct Flight {
    SessionFault fault = SessionFault::none;
    std::int64_t fault_ns = 0;
  };

  void run();
  void collect();
  void take(const SessionEntry& entry);
  void append(const SessionEntry& entry);
  void append_end(std::string& to);
  void write_entries(bool all);
  void plan_flight(const SessionEntry& fault);
  void write_flight();
  void forget_old_flights() const;

  Options options_;
  const bool records_all_;
  SessionHeader header_;
  const Clock& clock_;
  ByteRing ring_;
  SessionCodec codec_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::string unwritten_;
  std::uint64_t unwritten_entries_ = 0;
  std::vector<std::byte> drained_;
  std::deque<Block> recent_;  // for a flight record: the entries of the last kFlightNs and kAfterFaultNs
  std::int64_t newest_ns_ = 0;
  std::uint64_t newest_sample_ = 0;
  std::uint64_t dropped_reported_ = 0;
  std::optional<Flight> flight_;
  std::array<std::int64_t, 256> last_flight_ns_ = {};  // time of the last flight record of each kind of fault; 0: none yet
  Result<void> write_result_;
  Counts counts_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace hapton
