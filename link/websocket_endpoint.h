#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// A WebSocket client that exchanges text messages (RFC 6455, ws://, no TLS: for services on this machine).
// RT: no. Threads: one.
class WebSocketEndpoint {
 public:
  // Largest message, bytes; a longer one closes the connection.
  static constexpr std::size_t kMaxMessageBytes = 1 << 20;

  // Error, one line with the system's text: no listener, no reply in time, or another protocol.
  static Result<std::unique_ptr<WebSocketEndpoint>> connect(const Address& to, std::int64_t timeout_ns);

  virtual ~WebSocketEndpoint() = default;

  // Sends or receives one message. False: the connection is closed, or the call took longer than timeout_ns, which closes it too.
  virtual bool send(std::string_view text, std::int64_t timeout_ns) = 0;
  virtual bool receive(std::string& into, std::int64_t timeout_ns) = 0;

  // Closes the connection in order: sends a close frame and waits for that of the peer. False: as for send.
  virtual bool close(std::int64_t timeout_ns) = 0;

  // Why the connection was closed; empty while it is open.
  virtual const std::string& reason() const = 0;
};

}  // namespace hapton
