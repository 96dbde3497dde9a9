#include "link/flood_filter.h"

#include <algorithm>
#include <limits>

#include "link/codec.h"
#include "link/seal_format.h"

namespace hapton {
namespace {

// A filter of a UDP socket reads from the UDP header on. Special offsets give it the IP header and a random number (linux/filter.h).
constexpr std::uint32_t kUdpHeaderBytes = 8;
constexpr std::uint32_t kNetwork = static_cast<std::uint32_t>(SKF_NET_OFF);
constexpr std::uint32_t kRandom = static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_RANDOM);
constexpr std::uint32_t kAll = 0xFFFFFFFF;

// Filters load big-endian words.
std::uint32_t word_at(const Address& address, std::size_t byte) {
  return static_cast<std::uint32_t>(address.ip[byte]) << 24 | static_cast<std::uint32_t>(address.ip[byte + 1]) << 16 |
         static_cast<std::uint32_t>(address.ip[byte + 2]) << 8 | address.ip[byte + 3];
}

bool is_kind(std::span<const std::byte> datagram, seal::Kind kind) {
  return datagram.size() >= seal::kCounterAt && datagram[2] == static_cast<std::byte>(kind);
}

// The session as a filter loads it: a big-endian word.
std::uint32_t session_of(std::span<const std::byte> datagram) {
  std::uint32_t session = 0;
  for (const std::byte byte : datagram.subspan(seal::kConnectionAt, 4)) session = session << 8 | static_cast<std::uint32_t>(byte);
  return session;
}

}  // namespace

void FloodFilter::note_expected(const Address& from, std::uint32_t connection, std::int64_t now_ns) noexcept {
  std::array<std::byte, seal::kCounterAt> header = {};
  seal::store(connection, seal::bytes_of(std::span<std::byte>(header)) + seal::kConnectionAt);
  remember({from, session_of(header), now_ns, false});
}

void FloodFilter::note_sent(const Address& to, std::span<const std::byte> datagram, std::int64_t now_ns) noexcept {
  if (is_kind(datagram, seal::Kind::data)) remember({to, session_of(datagram), now_ns, true});
}

// A peer that agrees on one session after another displaces other such peers, but none to which data has been sent.
void FloodFilter::remember(const KnownPeer& known) noexcept {
  KnownPeer* entry = &known_[last_known_];
  if (!entry->is(known.address, known.session)) {
    const auto found =
        std::find_if(known_.begin(), known_.end(), [&](const KnownPeer& other) { return other.is(known.address, known.session); });
    const auto is_replaced_before = [&](const KnownPeer& a, const KnownPeer& b) {
      const bool is_a_kept = a.was_sent_data && known.time_ns - a.time_ns <= kKnownNs;
      const bool is_b_kept = b.was_sent_data && known.time_ns - b.time_ns <= kKnownNs;
      return is_a_kept != is_b_kept ? is_b_kept : a.time_ns < b.time_ns;
    };
    entry = found != known_.end() ? &*found : &*std::min_element(known_.begin(), known_.end(), is_replaced_before);
  }
  const bool is_same = entry->is(known.address, known.session);
  if (!is_same || known.time_ns - entry->time_ns > kKnownNs) ++known_changes_;
  const bool was_sent_data = known.was_sent_data || (is_same && entry->was_sent_data);
  *entry = known;
  entry->was_sent_data = was_sent_data;
  last_known_ = static_cast<std::size_t>(entry - known_.data());
}

bool FloodFilter::is_known(const Address& from, std::uint32_t session) const noexcept {
  if (known_[last_known_].is(from, session)) return true;
  return std::any_of(known_.begin(), known_.end(), [&](const KnownPeer& known) { return known.is(from, session); });
}

void FloodFilter::note_received(const Address& from, std::span<const std::byte> datagram, bool is_oversized) noexcept {
  counts_.oversized += is_oversized ? 1 : 0;
  if (!is_oversized && is_kind(datagram, seal::Kind::data) && is_known(from, session_of(datagram))) return;
  if (is_oversized) counts_.last_oversized = from;
  ++unknown_datagrams_;
  ++counts_.unknown_peers;
  counts_.last_unknown_sender = from;
}

FloodFilter::Action FloodFilter::end_period(std::uint32_t dropped, std::int64_t now_ns) noexcept {
  if (now_ns < period_end_ns_) {
    may_admit_early_ = false;
    return install();
  }
  may_admit_early_ = true;
  const std::uint32_t newly_dropped = period_begin_ns_ == 0 ? 0 : dropped - last_dropped_;
  last_dropped_ = dropped;
  counts_.dropped += newly_dropped;
  counts_.filtered += is_installed_ ? newly_dropped : 0;
  const double passed_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(now_ns - period_begin_ns_, 1));
  const double rate_per_s = static_cast<double>(unknown_datagrams_ + newly_dropped) / passed_s;
  const bool is_flood = unknown_datagrams_ + newly_dropped >= kFloodDatagrams;
  unknown_datagrams_ = 0;
  period_begin_ns_ = now_ns;
  period_end_ns_ = now_ns + kPeriodNs;
  // The rate rises within a period and falls over many (to half in 34, 0.2 s), so that the passed share does not vary with the scheduler.
  rate_per_s_ = std::max(rate_per_s, 0.98 * rate_per_s_);
  if (is_flood) {
    last_flood_ns_ = now_ns;
    counts_.flood_per_s = rate_per_s_;
  }
  if (!is_installed_ && !is_flood) return Action::none;
  if (is_installed_ && now_ns - last_flood_ns_ > kQuietNs) {
    is_installed_ = false;
    rate_per_s_ = 0.0;
    return Action::remove;
  }
  counts_.floods += is_installed_ ? 0 : 1;
  // Installs another filter program only if the known peers changed or the rate doubled or fell to a quarter: each is a system call.
  const bool is_same =
      is_installed_ && built_changes_ == known_changes_ && rate_per_s_ < 2.0 * built_rate_per_s_ && rate_per_s_ > 0.25 * built_rate_per_s_;
  is_installed_ = true;
  return is_same ? Action::none : install();
}

FloodFilter::Action FloodFilter::install() noexcept {
  built_changes_ = known_changes_;
  built_rate_per_s_ = rate_per_s_;
  build(std::min(1.0, kPassedPerS / std::max(rate_per_s_, 1.0)));
  return Action::install;
}

void FloodFilter::add(std::uint16_t code, std::uint32_t k, std::uint8_t jump_true, std::uint8_t jump_false) noexcept {
  if (program_size_ < program_.size()) program_[program_size_++] = {code, jump_true, jump_false, k};
}

// Adds instructions that pass the datagrams of `known`: from its address, in its session. Others go on to the instructions that follow.
void FloodFilter::add_known(const KnownPeer& known) noexcept {
  const bool v4 = is_v4(known.address);
  const std::uint8_t words = v4 ? 1 : 4;
  const std::uint32_t source = kNetwork + (v4 ? 12 : 8);
  // Instructions after the port: version 3, two for each word, session 2, 1 to pass.
  const auto instructions_left = [&](std::uint8_t done) { return static_cast<std::uint8_t>(3 + 2 * words + 2 + 1 - done); };
  add(BPF_LD | BPF_H | BPF_ABS, 0);
  add(BPF_JMP | BPF_JEQ | BPF_K, known.address.port, 0, instructions_left(0));
  add(BPF_LD | BPF_B | BPF_ABS, kNetwork);
  add(BPF_ALU | BPF_AND | BPF_K, 0xF0);
  add(BPF_JMP | BPF_JEQ | BPF_K, v4 ? 0x40 : 0x60, 0, instructions_left(3));
  std::uint8_t done = 3;
  for (std::uint8_t word = 0; word < words; ++word) {
    done = static_cast<std::uint8_t>(done + 2);
    add(BPF_LD | BPF_W | BPF_ABS, source + 4U * word);
    add(BPF_JMP | BPF_JEQ | BPF_K, word_at(known.address, v4 ? 12 : 4U * word), 0, instructions_left(done));
  }
  add(BPF_LD | BPF_W | BPF_ABS, kUdpHeaderBytes + static_cast<std::uint32_t>(seal::kConnectionAt));
  add(BPF_JMP | BPF_JEQ | BPF_K, known.session, 0, 1);
  add(BPF_RET | BPF_K, kAll);
}

void FloodFilter::build(double passed_share) noexcept {
  program_size_ = 0;
  // Data datagrams of this version and a possible length are compared with the known addresses and sessions; all others pass at random.
  const std::uint32_t lead =
      0x08000000U | (static_cast<std::uint32_t>(kProtocolVersion) << 16) | (static_cast<std::uint32_t>(seal::Kind::data) << 8);
  std::array<const KnownPeer*, kMaxKnownPeers> passing = {};
  std::size_t count = 0;
  for (const KnownPeer& known : known_) {
    if (known.time_ns > 0 && period_begin_ns_ - known.time_ns <= kKnownNs) passing[count++] = &known;
  }
  // A conditional jump of a filter reaches 255 instructions, an unconditional jump all of them.
  add(BPF_LD | BPF_W | BPF_LEN, 0);
  add(BPF_JMP | BPF_JGE | BPF_K, kUdpHeaderBytes + seal::kOverheadBytes, 1, 0);
  const std::size_t too_short = program_size_;
  add(BPF_JMP | BPF_JA, 0);
  add(BPF_JMP | BPF_JGT | BPF_K, kUdpHeaderBytes + kMaxDatagramBytes, 0, 1);
  const std::size_t too_long = program_size_;
  add(BPF_JMP | BPF_JA, 0);
  add(BPF_LD | BPF_W | BPF_ABS, kUdpHeaderBytes);
  add(BPF_JMP | BPF_JEQ | BPF_K, lead, 1, 0);
  const std::size_t other_kind = program_size_;
  add(BPF_JMP | BPF_JA, 0);
  for (std::size_t n = 0; n < count; ++n) add_known(*passing[n]);
  const std::size_t random_pass = program_size_;
  for (const std::size_t jump : {too_short, too_long, other_kind}) program_[jump].k = static_cast<std::uint32_t>(random_pass - jump - 1);
  add(BPF_LD | BPF_W | BPF_ABS, kRandom);
  add(BPF_JMP | BPF_JGT | BPF_K, static_cast<std::uint32_t>(passed_share * std::numeric_limits<std::uint32_t>::max()), 1, 0);
  add(BPF_RET | BPF_K, kAll);
  add(BPF_RET | BPF_K, 0);
}

}  // namespace hapton
