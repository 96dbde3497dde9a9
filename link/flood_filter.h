#pragma once

#include <linux/filter.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/endpoint.h"

namespace hapton {

// Detects a flood from unknown peers at the hub's socket, and makes the BPF program with which the kernel drops their datagrams, so that
// they cost this process no system calls. A peer is known for kKnownNs after it agreed on a session or was sent data. Data of known peers
// in their sessions passes. Other datagrams pass at random, about kPassedPerS in all, so nodes can still join, and rejected datagrams are
// counted as a sample. Without a flood nothing is filtered. The filter examines source, version, kind, session and length; it does not
// authenticate. The caller installs the program at its socket. Units: ns of the caller's monotonic clock, datagrams. RT: yes. Threads: one.
class FloodFilter {
 public:
  static constexpr std::size_t kMaxKnownPeers = 32;        // twice HubPeers::kCapacity
  static constexpr std::int64_t kKnownNs = 5'000'000'000;  // five times HubPeers::kPeerTimeoutNs: longer than a live node is silent
  // A flood begins in a period with at least kFloodDatagrams datagrams from unknown peers or dropped by the kernel (10,000 a second: 1 % of
  // a CPU at 1 us each). It ends after kQuietNs without such a period.
  static constexpr std::int64_t kPeriodNs = 5'000'000;
  static constexpr std::uint64_t kFloodDatagrams = 50;
  static constexpr std::int64_t kQuietNs = 2'000'000'000;  // so that a flood with gaps is one flood; a free choice
  static constexpr double kPassedPerS = 5000.0;            // 5 ms of work a second, at 1 us each; a choice
  static constexpr std::size_t kMaxInstructions = 640;     // at most 524 are used: 16 for each known IPv6 peer and 12 around them

  // What the caller has to do with the filter at its socket.
  enum class Action : std::uint8_t { none, install, remove };

  // A session was agreed on: data in it is expected from this address.
  void note_expected(const Address& from, std::uint32_t connection, std::int64_t now_ns) noexcept;
  void note_sent(const Address& to, std::span<const std::byte> datagram, std::int64_t now_ns) noexcept;
  // A datagram was received. If it is oversized, `datagram` is the part that was read.
  void note_received(const Address& from, std::span<const std::byte> datagram, bool is_oversized) noexcept;

  // Whether to call end_period() now: the period is over, or a new peer has to be admitted.
  bool is_due(std::int64_t now_ns) const noexcept { return now_ns >= period_end_ns_ || has_new_peer(); }
  // Whether a filter is installed: during a flood and kQuietNs beyond.
  bool is_installed() const noexcept { return is_installed_; }
  // Evaluates the last period, or, before its end, only admits a new peer. Pre: is_due(now_ns). dropped: number of datagrams that the
  // kernel has dropped at this socket, by the filter or for lack of room; modulo 2^32.
  Action end_period(std::uint32_t dropped, std::int64_t now_ns) noexcept;
  // After Action::install: the program, valid until the next end_period().
  std::span<sock_filter> program() noexcept { return std::span(program_).first(program_size_); }

  const SocketCounts& counts() const noexcept { return counts_; }

 private:
  struct KnownPeer {
    Address address;
    std::uint32_t session = 0;  // session number in the byte order in which a filter loads it
    std::int64_t time_ns = 0;
    bool was_sent_data = false;
    bool is(const Address& at, std::uint32_t in) const noexcept { return session == in && address == at; }
  };

  // There is a new known peer that the program does not admit yet.
  bool has_new_peer() const noexcept { return is_installed_ && may_admit_early_ && built_changes_ != known_changes_; }
  void remember(const KnownPeer& known) noexcept;
  Action install() noexcept;
  bool is_known(const Address& from, std::uint32_t session) const noexcept;
  void build(double passed_share) noexcept;
  void add(std::uint16_t code, std::uint32_t k, std::uint8_t jump_true = 0, std::uint8_t jump_false = 0) noexcept;
  void add_known(const KnownPeer& known) noexcept;

  std::array<KnownPeer, kMaxKnownPeers> known_ = {};
  std::size_t last_known_ = 0;       // index of the peer noted last, most likely also the next one
  std::uint64_t known_changes_ = 0;  // how often a peer became known
  std::uint64_t built_changes_ = 0;  // known_changes_ when the program was made
  SocketCounts counts_;
  std::uint64_t unknown_datagrams_ = 0;  // in this period
  std::uint32_t last_dropped_ = 0;       // at the end of the last period
  std::int64_t period_end_ns_ = 0;       // end of this period
  std::int64_t period_begin_ns_ = 0;     // beginning of this period
  std::int64_t last_flood_ns_ = 0;       // end of the last period with a flood
  double rate_per_s_ = 0.0;              // rate of unknown and dropped datagrams; declines slowly
  double built_rate_per_s_ = 0.0;        // that rate when the program was made
  bool is_installed_ = false;
  bool may_admit_early_ = false;  // once per period a new session is admitted at once
  std::array<sock_filter, kMaxInstructions> program_ = {};
  std::size_t program_size_ = 0;
};

}  // namespace hapton
