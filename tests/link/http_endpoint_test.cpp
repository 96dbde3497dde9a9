#include "link/http_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <thread>

namespace hapton {
namespace {

namespace asio = boost::asio;
using testing::HasSubstr;

constexpr std::int64_t kHttpTimeoutNs = 2'000'000'000;

// Accepts one connection, reads the request, and replies with the given text.
class OneReplyServer {
 public:
  explicit OneReplyServer(std::string reply)
      : thread_([this, text = std::move(reply)] {
          asio::ip::tcp::socket peer(context_);
          boost::system::error_code error;
          acceptor_.accept(peer, error);
          asio::streambuf buffer;
          asio::read_until(peer, buffer, "\r\n\r\n", error);
          asio::write(peer, asio::buffer(text), error);
        }) {}
  ~OneReplyServer() { thread_.join(); }

  Address address() const {
    Address address;
    address.ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1};
    address.port = acceptor_.local_endpoint().port();
    return address;
  }

 private:
  asio::io_context context_;
  asio::ip::tcp::acceptor acceptor_{context_, {asio::ip::address_v4::loopback(), 0}};
  std::thread thread_;
};

TEST(HttpEndpoint, ReadsWhatIsThere) {
  const OneReplyServer server("HTTP/1.1 200 OK\r\nContent-Length: 7\r\n\r\n3.5.2.0");
  const auto text = read_http(server.address(), "/version", kHttpTimeoutNs);
  ASSERT_TRUE(text) << text.error().what;
  EXPECT_EQ(*text, "3.5.2.0");
}

TEST(HttpEndpoint, OtherStatusesAreErrors) {
  const OneReplyServer server("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
  const auto text = read_http(server.address(), "/version", kHttpTimeoutNs);
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().what, HasSubstr("404 for /version"));
}

TEST(HttpEndpoint, MoreThan64KiBOrOtherThanHttpIsRejected) {
  for (const std::string& reply :
       {"HTTP/1.1 200 OK\r\nContent-Length: 70000\r\n\r\n" + std::string(70000, 'a'), std::string("SSH-2.0-x\r\n")}) {
    const OneReplyServer server(reply);
    EXPECT_FALSE(read_http(server.address(), "/", kHttpTimeoutNs)) << reply.substr(0, 40);
  }
}

TEST(HttpEndpoint, NobodyThereIsAnErrorAtOnce) {
  Address gone;
  {
    asio::io_context context;
    asio::ip::tcp::acceptor acceptor(context, {asio::ip::address_v4::loopback(), 0});
    gone.ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1};
    gone.port = acceptor.local_endpoint().port();
  }
  EXPECT_FALSE(read_http(gone, "/", kHttpTimeoutNs));
}

}  // namespace
}  // namespace hapton
