#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "link/hub_peers.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"

namespace hapton {

// A hub in its own thread and with its own key, which nodes can join. A function is called with each message that they send, in the hub's
// thread.
class ReplyingHub {
 public:
  // If it returns false, the hub is silent from then on.
  using OnMessage = std::function<bool(HubPeers& peers, std::size_t peer, const Message& message)>;

  explicit ReplyingHub(OnMessage on_message) : on_message_(std::move(on_message)), thread_([this] { run(); }) {}
  ~ReplyingHub() { end(); }
  ReplyingHub(const ReplyingHub&) = delete;
  ReplyingHub& operator=(const ReplyingHub&) = delete;

  std::string address() const { return to_string(endpoint_->local_address()); }
  std::string key_file() const { return key_file_; }
  // Ends the hub's thread: after that the test can read whatever the function has written.
  void end() {
    is_ending_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() {
    const LinkKey key = *read_key_file(key_file_);
    SealedHub sealed(*endpoint_, clock_, key);
    HubPeers peers(sealed, clock_, make_random_id(), 1000.0);
    Datagram datagram;
    bool is_replying = true;
    while (!is_ending_) {
      const std::int64_t until_ns = clock_.now_ns() + kNanosecondsPerMillisecond;
      if (!is_replying) {
        clock_.sleep_until_ns(until_ns);
        continue;
      }
      const PeerEvent event = peers.receive(datagram, until_ns);
      if (event.kind == PeerEvent::Kind::message) is_replying = on_message_(peers, event.peer, datagram.message);
    }
  }

  static std::string make_key(const std::string& path) {
    (void)make_key_file(path);
    return path;
  }

  ScratchFolder folder_;
  std::string key_file_ = make_key((folder_.path() / "key").string());
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  OnMessage on_message_;
  std::atomic<bool> is_ending_{false};
  std::thread thread_;
};

}  // namespace hapton
