#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/mailbox.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// Serves the hub's report to tools: they request it, a thread without deadlines writes it, and the network side sends it, one part per
// datagram and at most one datagram per cycle. RT: accept and serve yes, no heap; publish no. Threads: the network side's calls accept and
// serve, one other take_request and publish.
class ReportServer {
 public:
  // The network side: this peer requests a part; an earlier request of it is dropped.
  void accept(std::size_t peer, const ReportRequest& request) noexcept;
  // The network side, once a cycle: replies to one pending request, if its part is there.
  void serve(HubPeers& peers) noexcept;

  // The other thread: true once when a fresh report was requested.
  bool take_request() noexcept { return is_requested_.exchange(false, std::memory_order_acq_rel); }
  // Publishes a fresh report, which later ones replace.
  void publish(std::string json, std::string csv);

 private:
  struct Texts {
    std::uint32_t revision = 0;
    std::string json;
    std::string csv;
  };
  struct Waiting {
    ReportRequest request;
    std::uint32_t newer_than = 0;  // for a request of a new report: the newest revision when it was received
  };

  bool reply(HubPeers& peers, std::size_t peer) noexcept;

  Mailbox<Texts> texts_;
  std::uint32_t revision_ = 0;  // of the newest report; only the thread that publishes uses it
  std::atomic<bool> is_requested_{false};
  std::array<std::optional<Waiting>, HubPeers::kCapacity> waiting_ = {};
  std::size_t next_peer_ = 0;
  ReportPart part_;
};

}  // namespace hapton
