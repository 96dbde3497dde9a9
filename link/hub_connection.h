#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "link/hub_client.h"
#include "link/sealed_client.h"
#include "runtime/clock.h"

namespace hapton {

// A node's whole connection to its hub, for programs that users write: a socket, the sealing and the client that joins.
// RT: set-up only; for calls of client() see HubClient. Threads: one at a time.
class HubConnection {
 public:
  struct Settings {
    std::string hub = "127.0.0.1";  // HOST or HOST:PORT
    std::string key_file = {};      // empty: this user's shared key, for a hub on this host
    // Whether key agreements have a thread of their own, so that a node that computes forces never waits for one.
    bool has_worker = false;
  };

  // Error, one line: a bad address or key, or no socket. It does not wait for a hub: wait_until_joined does.
  static Result<std::unique_ptr<HubConnection>> open(NodeRole role, const Settings& settings);
  ~HubConnection();
  HubConnection(const HubConnection&) = delete;
  HubConnection& operator=(const HubConnection&) = delete;

  HubClient& client() noexcept { return *client_; }
  const Clock& clock() const noexcept { return clock_; }

  // Error, one line: no hub has replied in time, or one has rejected this node for 0.2 s. Messages that arrive meanwhile are dropped.
  Result<void> wait_until_joined(double seconds);

 private:
  HubConnection(const Address& hub, NodeRole role) : hub_(hub), role_(role) {}

  Address hub_;
  NodeRole role_;
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_;
  std::unique_ptr<SealedClient> sealed_;
  std::unique_ptr<HubClient> client_;
};

}  // namespace hapton
