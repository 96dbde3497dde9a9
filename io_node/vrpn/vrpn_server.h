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

constexpr std::uint16_t kPort = 3883;  // of VRPN, assigned by IANA

// Shows one device to VRPN clients, as NAME@host: Tracker (stylus and proxy), Button, Analog and ForceDevice. It accepts nothing from them:
// requested forces are rejected. It has a thread of low priority that the servo never waits for, and takes samples from a Feed. RT: no.
// Threads: made and ended by one.
class Server {
 public:
  struct Options {
    std::string address = "127.0.0.1:3883";
    std::string name = "Phantom0";
    DeviceLimits limits;
    double rate_hz = 500.0;  // of reports, at most
  };

  // Error: one line: bad address, port in use, a name that VRPN cannot carry.
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
