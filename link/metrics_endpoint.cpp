#include "link/metrics_endpoint.h"

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/system/system_error.hpp>
#include <chrono>
#include <cstddef>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "link/address_endpoint.h"
#include "link/asio_guard.h"
#include "link/link_key.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr auto kPatience = std::chrono::seconds(2);            // for a client to send its request, and to read the reply
constexpr std::size_t kMaxClients = 16;                        // usually one or two ask; a further one closes the oldest
constexpr auto kAcceptPause = std::chrono::milliseconds(100);  // if the process has no descriptor left
constexpr std::size_t kMaxRequestBytes = 8192;                 // a scraper sends a few hundred

// A browser that was directed here by another name (DNS rebinding) sends that name as Host. A client without Host is not a browser.
bool is_host_ours(std::string_view host) {
  if (host.empty()) return true;
  const std::size_t end = host.starts_with('[') ? host.find(']') : host.find(':');
  const std::string name(host.starts_with('[') ? host.substr(1, end - 1) : host.substr(0, end));
  if (beast::iequals(name, "localhost")) return true;
  error_code error;
  const asio::ip::address literal = asio::ip::make_address(name, error);
  return !error && literal.is_loopback();
}

using Response = http::response<http::string_body>;

bool is_read(const http::request<http::empty_body>& request) {
  return request.method() == http::verb::get || request.method() == http::verb::head;
}
bool is_target(const http::request<http::empty_body>& request) { return request.target() == "/metrics" || request.target() == "/"; }
bool is_scrape(const http::request<http::empty_body>& request) { return is_read(request) && is_target(request); }

Response respond(const http::request<http::empty_body>& request, std::string text) {
  const bool is_get = is_read(request);
  const bool is_there = is_target(request);
  const auto host = request.find(http::field::host);
  const bool is_ours = host == request.end() || is_host_ours(std::string_view(host->value().data(), host->value().size()));
  const http::status status = !is_ours   ? http::status::forbidden
                              : !is_get  ? http::status::method_not_allowed
                              : is_there ? http::status::ok
                                         : http::status::not_found;
  Response response(status, 11);
  response.set(http::field::content_type, status == http::status::ok ? "text/plain; version=0.0.4" : "text/plain");
  response.body() = status == http::status::ok ? std::move(text) : is_ours ? "only GET /metrics is available\n" : "use localhost\n";
  response.keep_alive(false);
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  return response;
}

}  // namespace

struct MetricsEndpoint::State {
  // One request and its reply. Kept alive by its own callbacks.
  struct Client : std::enable_shared_from_this<Client> {
    Client(State& state_in, tcp::socket socket) : state(state_in), stream(std::move(socket)) {}

    void start() {
      parser.body_limit(0);
      parser.header_limit(kMaxRequestBytes);
      stream.expires_after(kPatience);
      http::async_read_header(stream, buffer, parser, [self = shared_from_this()](const error_code& error, std::size_t) {
        if (!error) self->await_text();
      });
    }

    void await_text() {
      if (!is_scrape(parser.get())) return reply();
      is_waiting = true;
      state.is_requested.store(true, std::memory_order_release);
      timer.expires_after(std::chrono::nanoseconds(kFreshNs));
      timer.async_wait([self = shared_from_this()](const error_code& wait_error) {
        if (!wait_error) self->reply_if_waiting();
      });
    }

    void reply_if_waiting() {
      if (!std::exchange(is_waiting, false)) return;
      timer.cancel();
      reply();
    }

    void reply() {
      response = respond(parser.get(), state.text());
      stream.expires_after(kPatience);
      http::async_write(stream, response, [self = shared_from_this()](const error_code&, std::size_t) {
        error_code ignored;
        self->stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
      });
    }

    State& state;
    beast::tcp_stream stream;
    beast::flat_buffer buffer{kMaxRequestBytes};
    http::request_parser<http::empty_body> parser;
    Response response;
    asio::steady_timer timer{stream.get_executor()};
    bool is_waiting = false;
  };

  void listen() {
    acceptor.async_accept([this](const error_code& error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        make_room();
        const auto client = std::make_shared<Client>(*this, std::move(socket));
        order.push_back(client);
        client->start();
        return listen();
      }
      // No descriptor is free: the pending client would be reported again at once.
      pause.expires_after(kAcceptPause);
      pause.async_wait([this](const error_code& wait_error) {
        if (!wait_error) listen();
      });
    });
  }

  // Closes the oldest connection, so that a new request is served however many silent connections there are.
  void make_room() {
    std::erase_if(order, [](const std::weak_ptr<Client>& client) { return client.expired(); });
    while (order.size() >= kMaxClients) {
      if (const auto longest = order.front().lock()) {
        error_code ignored;
        longest->stream.socket().close(ignored);
      }
      order.pop_front();
    }
  }

  // Runs in the context's thread after a new text was set.
  void reply_to_waiting() {
    for (const std::weak_ptr<Client>& one : order)
      if (const auto client = one.lock()) client->reply_if_waiting();
  }

  std::string text() {
    const std::lock_guard lock(mutex);
    return served;
  }

  std::deque<std::weak_ptr<Client>> order;  // oldest first
  std::atomic<bool> is_requested{false};
  std::mutex mutex;
  std::string served;
  Address local;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  asio::steady_timer pause{context};
  std::thread thread;
};

MetricsEndpoint::MetricsEndpoint(std::unique_ptr<State> state) : state_(std::move(state)) {}

MetricsEndpoint::~MetricsEndpoint() {
  state_->context.stop();
  if (state_->thread.joinable()) state_->thread.join();
}

Result<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::open(std::string_view bind_address) {
  const auto at = parse_address(bind_address, 0);
  if (!at) return tl::unexpected(at.error());
  if (!is_loopback(*at)) {
    return fail("metrics are served to this machine only, not at {}; give a loopback address, for example 127.0.0.1:9464", bind_address);
  }
  auto made = make_with_context<State>();
  if (!made) return fail("cannot serve metrics at TCP {}: {}", to_string(*at), made.error().what);
  std::unique_ptr<State> state = std::move(*made);
  const tcp::endpoint endpoint(to_asio(*at), at->port);
  error_code error;
  state->acceptor.open(endpoint.protocol(), error);
  if (!error) state->acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) state->acceptor.bind(endpoint, error);
  if (!error) state->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    return fail("cannot serve metrics at TCP {}: {}; choose another port", to_string(*at), error.message());
  }
  state->local = *at;
  state->local.port = state->acceptor.local_endpoint(error).port();
  state->listen();
  State& running = *state;
  state->thread = start_thread([&running] { running.context.run(); });
  return std::unique_ptr<MetricsEndpoint>(new MetricsEndpoint(std::move(state)));
}

void MetricsEndpoint::set_text(std::string text) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->served = std::move(text);
  }
  asio::post(state_->context, [state = state_.get()] { state->reply_to_waiting(); });
}

bool MetricsEndpoint::take_request() noexcept { return state_->is_requested.exchange(false, std::memory_order_acq_rel); }

const Address& MetricsEndpoint::local_address() const { return state_->local; }

}  // namespace hapton
