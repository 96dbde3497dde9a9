#pragma once

#include <cstdint>
#include <string_view>
#include <utility>

#include "link/codec.h"
#include "link/session_entry.h"

namespace hapton {

// Entries of a made recording: samples at 1 kHz, all in contact.
constexpr std::int64_t kCyclesStartNs = 7'000'000'000;

inline std::int64_t sample_ns(std::uint64_t sample) { return kCyclesStartNs + static_cast<std::int64_t>(sample) * 1'000'000; }

inline SessionEntry cycle_of(std::uint64_t sample) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::cycle;
  entry.time_ns = sample_ns(sample) + 200'000;
  entry.cycle = {.sample = sample, .late_ns = 3000, .written_n = Vec3(0.0, 0.0, 0.5), .missed = sample == 3 ? 2U : 0U};
  entry.cycle.device = CycleSample{.time_ns = sample_ns(sample), .p_WD = Vec3(1e-4 * static_cast<double>(sample), 0.0, 0.2), .buttons = 5};
  return entry;
}

inline ForceCommand force_of(std::uint64_t sample) {
  return {.echo_sample = sample,
          .echo_sample_time_ns = sample_ns(sample),
          .force_n = Vec3(0.0, 0.0, static_cast<double>(sample)),
          .visual_offset_m = Vec3(0.0, 0.0, 1e-3),
          .contact = true,
          .object = 1};
}

inline std::pair<SessionEntry, Datagram> arrival_of(const ForceCommand& force, std::int64_t time_ns) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::received;
  entry.time_ns = time_ns;
  return {entry, Datagram{{}, force}};
}

inline SessionEntry marker_of(std::uint64_t sample, std::string_view text) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::marker;
  entry.time_ns = sample_ns(sample) + 100'000;
  entry.marker = {sample, NodeRole::tool, text};
  return entry;
}

}  // namespace hapton
