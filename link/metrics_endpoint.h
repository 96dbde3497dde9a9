#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// Serves one text by HTTP at /metrics, to this machine only, in its own thread, for Prometheus and curl. Each request waits up to kFreshNs
// for a text that is newer than the request; otherwise it gets the last one. RT: no. Threads: any.
class MetricsEndpoint {
 public:
  // bind_address: a loopback address and port, port 0 takes a free one. Error: one line: not loopback, port in use, a bad address.
  static Result<std::unique_ptr<MetricsEndpoint>> open(std::string_view bind_address);

  // Ends the thread and closes all connections.
  ~MetricsEndpoint();
  MetricsEndpoint(const MetricsEndpoint&) = delete;
  MetricsEndpoint& operator=(const MetricsEndpoint&) = delete;

  // How long a request waits for a fresh text.
  static constexpr std::int64_t kFreshNs = 500'000'000;

  // True once after a request has begun to wait.
  bool take_request() noexcept;
  // Sets the text to serve, and replies with it to waiting requests.
  void set_text(std::string text);

  const Address& local_address() const;

 private:
  struct State;
  explicit MetricsEndpoint(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton
