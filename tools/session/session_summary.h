#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/ns_between.h"
#include "link/codec.h"
#include "link/session_entry.h"
#include "recording/object_changes.h"
#include "runtime/latency_histogram.h"
#include "tools/session/session_replay.h"

namespace hapton {

// A summary of a recording, gathered entry by entry. RT: no. Threads: one.
class SessionSummary {
 public:
  void add(const SessionEntry& entry, const Datagram* datagram);

  // Returns a page of text for people.
  std::string to_text(const SessionHeader& header) const;

  const HapticsSetups& setups() const { return setups_; }
  const MaterialStates& materials() const { return materials_; }
  const ObjectMoves& moves() const { return moves_; }
  ReplayedCarves carves() const;
  const FirstShapes& first_shapes() const { return first_shapes_; }
  // Number of cycles whose force io_node computed itself, from parts of the scene; no reply of the haptics node has these forces.
  std::uint64_t local_forces() const { return local_forces_; }

 private:
  struct Traffic {
    std::uint64_t received = 0;
    std::uint64_t sent = 0;
    std::uint64_t bytes = 0;
  };
  struct Fault {
    std::int64_t time_ns = 0;
    SessionFault fault = SessionFault::none;
  };

  struct Marker {
    std::int64_t time_ns = 0;
    std::uint64_t sample = 0;
    std::string text;
  };

  void add_force(std::uint64_t sender, const ForceCommand& force, std::int64_t time_ns);
  double seconds() const { return seconds_between(first_ns_, last_ns_); }

  std::uint64_t entries_ = 0;
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
  std::map<std::string, Traffic> traffic_;  // by the name of the message
  std::uint64_t contact_forces_ = 0;
  double max_force_n_ = 0.0;
  double max_written_n_ = 0.0;
  double max_torque_nm_ = 0.0;
  double max_written_nm_ = 0.0;
  std::uint64_t local_forces_ = 0;
  LatencyHistogram round_trip_;
  LatencyHistogram lateness_;
  std::uint64_t cycles_ = 0;
  std::uint64_t missed_cycles_ = 0;
  std::map<MissCause, std::uint64_t> miss_causes_;
  std::uint64_t newest_sample_ = 0;
  std::uint64_t lost_samples_ = 0;
  std::uint64_t gaps_ = 0;
  std::uint64_t dropped_entries_ = 0;
  std::vector<Fault> faults_;    // the first ones
  std::vector<Marker> markers_;  // likewise
  std::uint64_t marker_count_ = 0;
  std::map<SessionFault, std::uint64_t> fault_counts_;
  HapticsSetups setups_;
  MaterialStates materials_;
  ObjectMoves moves_;
  std::set<std::pair<std::uint64_t, std::uint32_t>> shape_serials_;  // by sender and serial
  FirstShapes first_shapes_;
  ObjectChanges changes_{0};  // times are not used, only whether they are known
};

}  // namespace hapton
