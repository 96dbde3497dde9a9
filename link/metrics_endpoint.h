#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// Serves one text by HTTP at /metrics, to this machine only, in a thread of its own: what Prometheus and curl read.
// RT: no. Threads: any.
class MetricsEndpoint {
 public:
  // bind_address: a loopback address and port, port 0 takes a free one. Error: one line: not loopback, port in use, no address.
  static Result<std::unique_ptr<MetricsEndpoint>> open(std::string_view bind_address);

  // Ends the thread; who is being answered is cut off.
  ~MetricsEndpoint();
  MetricsEndpoint(const MetricsEndpoint&) = delete;
  MetricsEndpoint& operator=(const MetricsEndpoint&) = delete;

  // What is served from now on.
  void set_text(std::string text);

  const Address& local_address() const;

 private:
  struct State;
  explicit MetricsEndpoint(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton
