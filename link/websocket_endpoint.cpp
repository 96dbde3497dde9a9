#include "link/websocket_endpoint.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>

#include "link/address_endpoint.h"
#include "link/asio_guard.h"

namespace hapton {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

class BeastEndpoint final : public WebSocketEndpoint {
 public:
  bool open(const Address& to, std::int64_t timeout_ns) {
    // The stream's own time limits are off: every byte would restart them.
    stream_.set_option(websocket::stream_base::timeout{websocket::stream_base::none(), websocket::stream_base::none(), false});
    stream_.read_message_max(kMaxMessageBytes);
    const bool is_connected = run(timeout_ns, [&](auto&& done) {
      lowest().async_connect(tcp::endpoint(to_asio(to), to.port), [done](const error_code& error) { done(error); });
    });
    if (!is_connected) return false;
    error_code ignored;
    lowest().socket().set_option(tcp::no_delay(true), ignored);
    return run(timeout_ns,
               [&](auto&& done) { stream_.async_handshake(to_string(to), "/", [done](const error_code& error) { done(error); }); });
  }

  bool send(std::string_view text, std::int64_t timeout_ns) override {
    stream_.text(true);
    return run(timeout_ns, [&](auto&& done) {
      stream_.async_write(asio::buffer(text), [done](const error_code& error, std::size_t) { done(error); });
    });
  }

  bool receive(std::string& into, std::int64_t timeout_ns) override {
    buffer_.clear();
    const bool is_received =
        run(timeout_ns, [&](auto&& done) { stream_.async_read(buffer_, [done](const error_code& error, std::size_t) { done(error); }); });
    if (is_received) into = beast::buffers_to_string(buffer_.cdata());
    return is_received;
  }

  bool close(std::int64_t timeout_ns) override {
    const bool is_closed = run(timeout_ns, [&](auto&& done) {
      stream_.async_close(websocket::close_code::normal, [done](const error_code& error) { done(error); });
    });
    if (is_closed) reason_ = "closed by this side";
    is_over_ = true;
    return is_closed;
  }

  const std::string& reason() const override { return reason_; }

 private:
  beast::tcp_stream& lowest() { return beast::get_lowest_layer(stream_); }

  // Starts one operation and waits for its end. If it takes too long, the connection ends: half a message is of no use.
  template <class Start>
  bool run(std::int64_t timeout_ns, Start&& start) {
    if (is_over_) return false;
    lowest().expires_after(std::chrono::nanoseconds(timeout_ns));
    error_code result;
    start([&result](const error_code& error) { result = error; });
    context_.restart();
    context_.run();
    if (!result) return true;
    is_over_ = true;
    reason_ = result == beast::error::timeout ? "no reply in time" : result.message();
    error_code ignored;
    lowest().socket().close(ignored);
    return false;
  }

  asio::io_context context_{1};
  websocket::stream<beast::tcp_stream> stream_{context_};
  beast::flat_buffer buffer_{kMaxMessageBytes};
  bool is_over_ = false;
  std::string reason_;
};

}  // namespace

Result<std::unique_ptr<WebSocketEndpoint>> WebSocketEndpoint::connect(const Address& to, std::int64_t timeout_ns) {
  auto made = make_with_context<BeastEndpoint>();
  if (!made) return fail("{}: {}", to_string(to), made.error().what);
  std::unique_ptr<BeastEndpoint> endpoint = std::move(*made);
  if (!endpoint->open(to, timeout_ns)) return fail("{}: {}", to_string(to), endpoint->reason());
  return endpoint;
}

}  // namespace hapton
