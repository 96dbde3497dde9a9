#include "link/http_endpoint.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <chrono>

#include "link/address_endpoint.h"
#include "link/asio_guard.h"

namespace hapton {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kMaxBytes = 1 << 16;  // of a reply; the services send a version and a few lines

// One request and its reply, with one time limit for both.
class HttpExchange {
 public:
  error_code run(const Address& to, std::string_view target, std::int64_t timeout_ns) {
    request_.method(http::verb::get);
    request_.target(beast::string_view(target.data(), target.size()));
    request_.set(http::field::host, to_string(to));
    request_.set(http::field::connection, "close");
    parser_.body_limit(kMaxBytes);
    error_code result;
    stream_.expires_after(std::chrono::nanoseconds(timeout_ns));
    stream_.async_connect(tcp::endpoint(to_asio(to), to.port), [&](const error_code& connect_error) {
      if (result = connect_error; result) return;
      http::async_write(stream_, request_, [&](const error_code& write_error, std::size_t) {
        if (result = write_error; result) return;
        http::async_read(stream_, buffer_, parser_, [&](const error_code& read_error, std::size_t) { result = read_error; });
      });
    });
    context_.run();
    return result;
  }
  const http::response<http::string_body>& response() const { return parser_.get(); }

 private:
  asio::io_context context_{1};
  beast::tcp_stream stream_{context_};
  beast::flat_buffer buffer_{kMaxBytes};
  http::request<http::empty_body> request_;
  http::response_parser<http::string_body> parser_;
};

}  // namespace

Result<std::string> read_http(const Address& to, std::string_view target, std::int64_t timeout_ns) {
  auto exchange = make_with_context<HttpExchange>();
  if (!exchange) return tl::unexpected(exchange.error());
  const error_code error = (*exchange)->run(to, target, timeout_ns);
  if (error) return fail("{}", error == beast::error::timeout ? "no reply in time" : error.message());
  const auto& response = (*exchange)->response();
  if (response.result() != http::status::ok) return fail("HTTP status {} for {}", response.result_int(), target);
  if (response.body().size() > kMaxBytes) return fail("more than {} bytes from {}", kMaxBytes, target);
  return response.body();
}

}  // namespace hapton
