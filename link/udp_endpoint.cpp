#include "link/udp_endpoint.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <charconv>
#include <ctime>
#include <optional>

namespace hapton {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr int kReceiveBufferBytes = 1 << 20;  // a second of 10 kHz traffic to a node that is paused

bool is_v4_mapped(const Address& address) {
  constexpr std::array<std::uint8_t, 12> kPrefix = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  return std::equal(kPrefix.begin(), kPrefix.end(), address.ip.begin());
}

asio::ip::address_v4 v4_of(const Address& address) {
  return asio::ip::address_v4({address.ip[12], address.ip[13], address.ip[14], address.ip[15]});
}

Address address_of(const udp::endpoint& endpoint) {
  Address address;
  address.port = endpoint.port();
  if (endpoint.address().is_v4()) {
    const auto bytes = endpoint.address().to_v4().to_bytes();
    address.ip[10] = address.ip[11] = 0xFF;
    std::copy(bytes.begin(), bytes.end(), address.ip.begin() + 12);
  } else {
    const auto bytes = endpoint.address().to_v6().to_bytes();
    std::copy(bytes.begin(), bytes.end(), address.ip.begin());
  }
  return address;
}

std::int64_t monotonic_ns() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecondNs + now.tv_nsec;
}

class UdpEndpoint final : public Endpoint {
 public:
  UdpEndpoint() : socket_(context_) {}

  error_code open(const udp::endpoint& local);

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  Address local_address() const override { return local_; }

 private:
  std::optional<udp::endpoint> remote(const Address& to) const noexcept;
  bool wait_readable(std::int64_t deadline_ns) noexcept;
  Received try_receive(std::span<std::byte> into, bool& empty) noexcept;

  asio::io_context context_;
  udp::socket socket_;
  Address local_;
  bool is_v4_ = true;
};

error_code UdpEndpoint::open(const udp::endpoint& local) {
  error_code error;
  is_v4_ = local.address().is_v4();
  socket_.open(local.protocol(), error);
  if (error) {
    return error;
  }
  if (!is_v4_) {
    socket_.set_option(asio::ip::v6_only(false), error);
    if (error) {
      return error;
    }
  }
  // The kernel may grant less than asked; that costs only how long a paused node can catch up.
  socket_.set_option(asio::socket_base::receive_buffer_size(kReceiveBufferBytes), error);
  socket_.bind(local, error);
  if (error) {
    return error;
  }
  socket_.non_blocking(true, error);
  if (error) {
    return error;
  }
  const udp::endpoint bound = socket_.local_endpoint(error);
  if (!error) {
    local_ = address_of(bound);
  }
  return error;
}

std::optional<udp::endpoint> UdpEndpoint::remote(const Address& to) const noexcept {
  if (is_v4_) {
    return is_v4_mapped(to) ? std::optional(udp::endpoint(v4_of(to), to.port)) : std::nullopt;
  }
  return udp::endpoint(asio::ip::address_v6(to.ip), to.port);
}

bool UdpEndpoint::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  const std::optional<udp::endpoint> endpoint = remote(to);
  if (!endpoint || datagram.size() > kMaxDatagramBytes) {
    return false;
  }
  // A refusal that an earlier datagram brought back is reported on the next call; it says nothing about this one: try again.
  for (int attempt = 0; attempt < 2; ++attempt) {
    error_code error;
    socket_.send_to(asio::buffer(datagram.data(), datagram.size()), *endpoint, 0, error);
    if (error != asio::error::connection_refused) {
      return !error;
    }
  }
  return false;
}

bool UdpEndpoint::wait_readable(std::int64_t deadline_ns) noexcept {
  pollfd readable = {.fd = socket_.native_handle(), .events = POLLIN, .revents = 0};
  while (true) {
    const std::int64_t left_ns = deadline_ns - monotonic_ns();
    if (left_ns <= 0) {
      return false;
    }
    const timespec timeout = {.tv_sec = left_ns / kSecondNs, .tv_nsec = left_ns % kSecondNs};
    const int ready = ppoll(&readable, 1, &timeout, nullptr);
    if (ready > 0) {
      return true;
    }
    if (ready == 0) {
      return false;
    }
    // EINTR, and ENOMEM under memory pressure: the rest of the time is still to be waited.
  }
}

Received UdpEndpoint::try_receive(std::span<std::byte> into, bool& empty) noexcept {
  udp::endpoint from;
  error_code error;
  const std::size_t bytes = socket_.receive_from(asio::buffer(into.data(), into.size()), from, MSG_TRUNC, error);
  empty = error == asio::error::would_block || error == asio::error::try_again;
  // With MSG_TRUNC the size of a datagram longer than the buffer is told; it is no datagram of ours.
  if (error || bytes > into.size()) {
    return {};
  }
  return {.bytes = bytes, .from = address_of(from)};
}

Received UdpEndpoint::receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept {
  // Poll before receiving when there is time to wait: two system calls in the common case instead of three.
  bool may_wait = monotonic_ns() < deadline_ns;
  while (true) {
    if (may_wait && !wait_readable(deadline_ns)) {
      may_wait = false;  // one last look
    }
    bool empty = false;
    const Received received = try_receive(into, empty);
    if (received.bytes > 0) {
      return received;
    }
    // Empty datagrams, oversized ones and ICMP refusals are passed over.
    if (empty && !may_wait) {
      return {};
    }
  }
}

Result<std::uint16_t> parse_port(std::string_view text, std::string_view whole) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size()) {
    return fail("address '{}': port '{}' is not a number from 0 to 65535", whole, text);
  }
  return port;
}

struct HostAndPort {
  std::string host;
  std::uint16_t port = 0;
};

Result<HostAndPort> split(std::string_view text, std::uint16_t default_port) {
  HostAndPort parts{std::string(text), default_port};
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t close = text.find(']');
    if (close == std::string_view::npos || (close + 1 < text.size() && text[close + 1] != ':')) {
      return fail("address '{}': an IPv6 address with a port is written [address]:port", text);
    }
    parts.host = text.substr(1, close - 1);
    if (close + 1 == text.size()) {
      return parts;
    }
    port = text.substr(close + 2);
  } else {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos || text.find(':', colon + 1) != std::string_view::npos) {
      return parts;  // no port, or a bare IPv6 address
    }
    parts.host = text.substr(0, colon);
    port = text.substr(colon + 1);
  }
  const Result<std::uint16_t> number = parse_port(port, text);
  if (!number) {
    return tl::unexpected(number.error());
  }
  parts.port = *number;
  return parts;
}

}  // namespace

Result<Address> parse_address(std::string_view text, std::uint16_t default_port) {
  Result<HostAndPort> parts = split(text, default_port);
  if (!parts) {
    return tl::unexpected(parts.error());
  }
  if (parts->host.empty()) {
    return fail("address '{}': no host before the port; write host:port, for example 127.0.0.1:{}", text, kDefaultHubPort);
  }
  if (parts->host.find('%') != std::string::npos) {
    return fail("address '{}': IPv6 zones (%interface) are not supported; use a global or unique local address", text);
  }
  error_code error;
  const asio::ip::address literal = asio::ip::make_address(parts->host, error);
  if (!error) {
    return address_of(udp::endpoint(literal, parts->port));
  }
  asio::io_context context;
  udp::resolver resolver(context);
  const auto found = resolver.resolve(parts->host, "", error);
  if (error || found.empty()) {
    return fail("address '{}': host '{}' is not known ({}); check the spelling or give its IP address", text, parts->host,
                error.message());
  }
  const auto v4 = std::find_if(found.begin(), found.end(), [](const auto& e) { return e.endpoint().address().is_v4(); });
  const auto best = v4 != found.end() ? v4 : found.begin();
  return address_of(udp::endpoint(best->endpoint().address(), parts->port));
}

std::string to_string(const Address& address) {
  if (is_v4_mapped(address)) {
    return fmt::format("{}:{}", v4_of(address).to_string(), address.port);
  }
  return fmt::format("[{}]:{}", asio::ip::address_v6(address.ip).to_string(), address.port);
}

Result<std::unique_ptr<Endpoint>> open_udp_endpoint(std::string_view bind_address) {
  const Result<Address> local = parse_address(bind_address);
  if (!local) {
    return tl::unexpected(local.error());
  }
  const udp::endpoint wanted = is_v4_mapped(*local) ? udp::endpoint(v4_of(*local), local->port)
                                                    : udp::endpoint(asio::ip::address_v6(local->ip), local->port);
  auto endpoint = std::make_unique<UdpEndpoint>();
  const error_code error = endpoint->open(wanted);
  if (error == asio::error::address_in_use) {
    return fail("cannot listen on UDP {}: another program holds this port; stop it or choose another port", to_string(*local));
  }
  if (error == boost::system::errc::address_not_available) {
    return fail("cannot listen on UDP {}: this host has no such address; use one of its own, or 0.0.0.0 for all",
                to_string(*local));
  }
  if (error) {
    return fail("cannot listen on UDP {}: {}", to_string(*local), error.message());
  }
  return endpoint;
}

}  // namespace hapton
