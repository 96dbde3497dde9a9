#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "io_node/servo_stats.h"
#include "io_node/servo_tap.h"
#include "link/hub_peers.h"
#include "link/messages.h"
#include "link/rate_limit.h"

namespace hapton {

// Records the markers that nodes send, each once, at the newest sample, and replies to each. A node may send kPerSecond in the long run and
// kBurst at once; markers beyond that are only counted, and at most ten a second get a reply. RT: yes. Threads: the network side's.
class MarkerLog {
 public:
  // A choice: people look at markers one by one. A flood adds at most 50 a second of each node to a recording.
  static constexpr std::int64_t kPerSecond = 50;
  static constexpr std::int64_t kBurst = 100;
  // Replies kept for each node, so that a request that is repeated gets the same reply.
  static constexpr std::size_t kRememberedReplies = 16;

  // Pre: all outlive this; tap may be null.
  MarkerLog(HubPeers& peers, ServoTap* tap, ServoStats& stats) noexcept : peers_(peers), tap_(tap), stats_(stats) {}

  // sample: number of the newest sample.
  void accept(const Marker& marker, const PeerEvent& event, std::uint64_t sample, std::int64_t now_ns) noexcept;
  // The node in this slot has left, or another one has taken it.
  void on_peer_gone(std::size_t peer) noexcept { sources_[peer] = {}; }

 private:
  struct Source {
    std::array<MarkerReply, kRememberedReplies> replies = {};  // a ring
    std::size_t count = 0;
    TokenBucket markers{kPerSecond, kBurst};
    TokenBucket rejections{10, 10};  // replies to markers beyond the limit
  };

  MarkerReply record(const Marker& marker, NodeRole role, std::uint64_t sample, std::int64_t now_ns) noexcept;

  HubPeers& peers_;
  ServoTap* tap_;
  ServoStats& stats_;
  std::array<Source, HubPeers::kCapacity> sources_ = {};
};

}  // namespace hapton
