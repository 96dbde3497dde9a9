#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "link/hub_peers.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"
#include "tools/live/hub_report.h"

namespace hapton {

// A hub in a thread of its own, which nodes can join and which has reports of one part, and nothing else.
class ReportingHub {
 public:
  // Of the n-th report, from 1.
  using Make = std::function<HubReport(int number)>;
  // When a whole report was sent, in the hub's thread. False: the hub is silent from then on.
  using After = std::function<bool()>;

  explicit ReportingHub(
      Make make, After after = [] { return true; })
      : make_(std::move(make)), after_(std::move(after)), thread_([this] { run(); }) {}
  ~ReportingHub() {
    ends_ = true;
    thread_.join();
  }
  ReportingHub(const ReportingHub&) = delete;
  ReportingHub& operator=(const ReportingHub&) = delete;

  std::string address() const { return to_string(endpoint_->local_address()); }
  std::string key_file() const { return key_file_; }

 private:
  void run() {
    const LinkKey key = *read_key_file(key_file_);
    SealedHub sealed(*endpoint_, clock_, key);
    HubPeers peers(sealed, clock_, make_random_id(), 1000.0);
    Datagram datagram;
    bool replies = true;
    while (!ends_) {
      if (!replies) {
        clock_.sleep_until_ns(clock_.now_ns() + kNanosecondsPerMillisecond);
        continue;
      }
      const PeerEvent event = peers.receive(datagram, clock_.now_ns() + kNanosecondsPerMillisecond);
      const auto* request = std::get_if<ReportRequest>(&datagram.message);
      if (event.kind == PeerEvent::Kind::message && request != nullptr) replies = reply(peers, event.peer, *request);
    }
  }
  bool reply(HubPeers& peers, std::size_t peer, const ReportRequest& request) {
    const bool is_table = request.document == ReportDocument::csv;
    if (!is_table) ++number_;
    const HubReport report = make_(number_);
    const std::string& text = is_table ? report.csv : report.json;
    ReportPart part;
    part.document = request.document;
    part.revision = static_cast<std::uint32_t>(number_);
    part.parts = 1;
    part.size = static_cast<std::uint16_t>(std::min(text.size(), part.text.size()));
    std::copy_n(text.begin(), part.size, part.text.begin());
    peers.send_to(peer, part);
    return !is_table || after_();
  }

  static std::string make_key(const std::string& path) {
    (void)make_key_file(path);
    return path;
  }

  ScratchFolder folder_;
  std::string key_file_ = make_key((folder_.path() / "key").string());
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  Make make_;
  After after_;
  int number_ = 0;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace hapton
