#include "link/websocket_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "link/address.h"

namespace hapton {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using boost::system::error_code;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::int64_t kWebSocketTimeoutNs = 30'000'000'000;
constexpr std::int64_t kShortTimeoutNs = 50'000'000;

// Accepts one connection and serves it as the test says, in a thread of its own.
class Service {
 public:
  explicit Service(std::function<void(tcp::socket&)> serve) : acceptor_(context_, {asio::ip::address_v4::loopback(), 0}) {
    thread_ = std::thread([this, serve = std::move(serve)] {
      tcp::socket socket(context_);
      error_code error;
      acceptor_.accept(socket, error);
      if (!error) serve(socket);
    });
  }
  ~Service() {
    // Ends the wait for a connection if the thread still waits for one.
    error_code ignored;
    tcp::socket(context_).connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }
  Address address() const { return *parse_address("127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port())); }

 private:
  asio::io_context context_;
  tcp::acceptor acceptor_;
  std::thread thread_;
};

// Reads until the client has closed the connection.
void read_all(tcp::socket& socket) {
  std::array<char, 256> block;
  error_code error;
  while (!error) socket.read_some(asio::buffer(block), error);
}

void echo(tcp::socket& socket) {
  beast::websocket::stream<tcp::socket&> stream(socket);
  error_code error;
  stream.accept(error);
  while (!error) {
    beast::flat_buffer buffer;
    stream.read(buffer, error);
    stream.text(stream.got_text());
    if (!error) stream.write(buffer.data(), error);
  }
}

TEST(WebSocketEndpoint, TextsGoThereAndBackAndItEndsInOrder) {
  Service service(&echo);
  auto endpoint = WebSocketEndpoint::connect(service.address(), kWebSocketTimeoutNs);
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  for (const std::string& text : {std::string("hello"), std::string(100'000, 'x'), std::string()}) {
    ASSERT_TRUE((*endpoint)->send(text, kWebSocketTimeoutNs)) << (*endpoint)->reason();
    std::string received = "of before";
    ASSERT_TRUE((*endpoint)->receive(received, kWebSocketTimeoutNs)) << (*endpoint)->reason();
    EXPECT_EQ(received, text);
  }
  EXPECT_TRUE((*endpoint)->close(kWebSocketTimeoutNs));
  EXPECT_EQ((*endpoint)->reason(), "closed by this side");
  EXPECT_FALSE((*endpoint)->send("more", kWebSocketTimeoutNs));
}

TEST(WebSocketEndpoint, AnotherProtocolIsRejectedInOneLine) {
  Service service([](tcp::socket& socket) {
    error_code error;
    asio::write(socket, asio::buffer(std::string("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")), error);
    read_all(socket);
  });
  const auto endpoint = WebSocketEndpoint::connect(service.address(), kWebSocketTimeoutNs);
  ASSERT_FALSE(endpoint);
  EXPECT_THAT(endpoint.error().what, StartsWith("127.0.0.1:"));
  EXPECT_GT(endpoint.error().what.size(), std::string("127.0.0.1:65535: ").size()) << "with the reason";
  EXPECT_EQ(endpoint.error().what.find('\n'), std::string::npos);
}

TEST(WebSocketEndpoint, WhoeverDoesNotReplyIsGivenUp) {
  Service service(&read_all);
  const auto endpoint = WebSocketEndpoint::connect(service.address(), kShortTimeoutNs);
  ASSERT_FALSE(endpoint);
  EXPECT_THAT(endpoint.error().what, HasSubstr("no reply in time"));
}

TEST(WebSocketEndpoint, WithoutAListenerThereIsNoConnection) {
  Address nobody;
  {
    asio::io_context context;
    const tcp::acceptor acceptor(context, {asio::ip::address_v4::loopback(), 0});
    nobody = *parse_address("127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()));
  }
  EXPECT_FALSE(WebSocketEndpoint::connect(nobody, kWebSocketTimeoutNs));
}

// A message of more than a megabyte could fill the memory, so it ends the connection. So does a message that does not come in time.
TEST(WebSocketEndpoint, WhatIsTooLongOrTooLateEndsTheConnection) {
  for (const bool is_long : {true, false}) {
    Service service([is_long](tcp::socket& socket) {
      beast::websocket::stream<tcp::socket&> stream(socket);
      error_code error;
      stream.accept(error);
      if (is_long) stream.write(asio::buffer(std::string(WebSocketEndpoint::kMaxMessageBytes + 1, 'x')), error);
      read_all(socket);
    });
    auto endpoint = WebSocketEndpoint::connect(service.address(), kWebSocketTimeoutNs);
    ASSERT_TRUE(endpoint) << endpoint.error().what;
    std::string received;
    EXPECT_FALSE((*endpoint)->receive(received, is_long ? kWebSocketTimeoutNs : kShortTimeoutNs));
    EXPECT_FALSE((*endpoint)->reason().empty());
    EXPECT_FALSE((*endpoint)->receive(received, kWebSocketTimeoutNs)) << "it is over";
  }
}

}  // namespace
}  // namespace hapton
