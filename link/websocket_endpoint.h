#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// The client's end of a WebSocket connection that carries texts (RFC 6455, ws://, no TLS: for services on this machine).
// RT: no. Threads: one.
class WebSocketEndpoint {
 public:
  // A peer that sends more in one message is cut off.
  static constexpr std::size_t kMostMessageBytes = 1 << 20;

  // Error: no listener, no reply in time, or another protocol; one line with the system's text.
  static Result<std::unique_ptr<WebSocketEndpoint>> connect(const Address& to, std::int64_t patience_ns);

  virtual ~WebSocketEndpoint() = default;

  // False: the connection is closed, or the call took longer than patience_ns, which closes it as well.
  virtual bool send(std::string_view text, std::int64_t patience_ns) = 0;
  virtual bool receive(std::string& into, std::int64_t patience_ns) = 0;

  // Closes the connection in order: sends a close frame and waits for that of the peer. False: as above.
  virtual bool close(std::int64_t patience_ns) = 0;

  // Why the connection is over.
  virtual const std::string& reason() const = 0;
};

}  // namespace hapton
