#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "core/base/result.h"
#include "io_node/vrpn/vrpn_client.h"
#include "io_node/vrpn/vrpn_feed.h"
#include "link/stream_endpoint.h"

namespace hapton::vrpn {

constexpr std::uint16_t kPort = 3883;  // the port of VRPN, assigned by IANA

// Reports one device to VRPN clients, as NAME@host: Tracker (stylus and proxy), Button, Analog and ForceDevice. Forces that a client
// requests are rejected. It reads samples from a Feed in a thread of low priority, for which no real-time thread waits. Frame W, SI units.
// RT: no. Threads: open and the destructor from one.
class Server {
 public:
  struct Options {
    std::string address = "127.0.0.1:3883";
    std::string name = "Phantom0";
    DeviceLimits limits;
    double rate_hz = 500.0;  // largest report rate
  };

  // Pre: feed outlives the server. Error, one line: invalid address, port in use, or a name that VRPN does not allow.
  static Result<std::unique_ptr<Server>> open(Feed& feed, const Options& options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const Address& local_address() const;

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton::vrpn
