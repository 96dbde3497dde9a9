#include "link/address_endpoint.h"

#include <fmt/core.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <charconv>
#include <cstring>

namespace hapton {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

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

int address_family(const Address& address) noexcept { return is_v4(address) ? AF_INET : AF_INET6; }

SocketAddress to_socket_address(const Address& address) noexcept {
  if (!is_v4(address)) return to_v6_socket_address(address);
  SocketAddress result;
  sockaddr_in v4 = {};
  v4.sin_family = AF_INET;
  v4.sin_port = htons(address.port);
  std::memcpy(&v4.sin_addr, address.ip.data() + 12, sizeof v4.sin_addr);
  std::memcpy(&result.storage, &v4, sizeof v4);
  result.size = sizeof v4;
  return result;
}

SocketAddress to_v6_socket_address(const Address& address) noexcept {
  SocketAddress result;
  sockaddr_in6 v6 = {};
  v6.sin6_family = AF_INET6;
  v6.sin6_port = htons(address.port);
  std::memcpy(&v6.sin6_addr, address.ip.data(), address.ip.size());
  std::memcpy(&result.storage, &v6, sizeof v6);
  result.size = sizeof v6;
  return result;
}

Address from_socket_address(const SocketAddress& address) noexcept {
  Address result;
  if (address.storage.ss_family == AF_INET) {
    sockaddr_in v4 = {};
    std::memcpy(&v4, &address.storage, sizeof v4);
    result.ip[10] = result.ip[11] = 0xFF;
    std::memcpy(result.ip.data() + 12, &v4.sin_addr, sizeof v4.sin_addr);
    result.port = ntohs(v4.sin_port);
  } else {
    sockaddr_in6 v6 = {};
    std::memcpy(&v6, &address.storage, sizeof v6);
    std::memcpy(result.ip.data(), &v6.sin6_addr, result.ip.size());
    result.port = ntohs(v6.sin6_port);
  }
  return result;
}

Address local_address(int socket) noexcept {
  SocketAddress bound;
  if (::getsockname(socket, bound.get(), &bound.size) != 0) return {};
  return from_socket_address(bound);
}

asio::ip::address to_asio(const Address& address) noexcept {
  if (is_v4(address)) return asio::ip::address_v4({address.ip[12], address.ip[13], address.ip[14], address.ip[15]});
  return asio::ip::address_v6(address.ip);
}

Address from_asio(const asio::ip::address& ip, std::uint16_t port) noexcept {
  Address address{.port = port};
  if (ip.is_v4()) {
    const auto bytes = ip.to_v4().to_bytes();
    address.ip[10] = address.ip[11] = 0xFF;
    std::copy(bytes.begin(), bytes.end(), address.ip.begin() + 12);
  } else {
    address.ip = ip.to_v6().to_bytes();
  }
  return address;
}

Result<Address> parse_address(std::string_view text, std::uint16_t default_port) {
  Result<HostAndPort> parts = split(text, default_port);
  if (!parts) {
    return tl::unexpected(parts.error());
  }
  if (parts->host.empty()) {
    return fail("address '{}': no host before the port; write host:port, for example 127.0.0.1:{}", text, parts->port);
  }
  if (parts->host.find('%') != std::string::npos) {
    return fail("address '{}': IPv6 zones (%interface) are not supported; use a global or unique local address", text);
  }
  if (parts->host.find_first_not_of("0123456789") == std::string::npos) {
    return fail("address '{}': a number alone may be a port or an address; write 127.0.0.1:{} for the port", text, parts->host);
  }
  error_code error;
  const asio::ip::address literal = asio::ip::make_address(parts->host, error);
  if (!error) {
    return from_asio(literal, parts->port);
  }
  asio::io_context context;
  udp::resolver resolver(context);
  const auto found = resolver.resolve(parts->host, "", error);
  if (error || found.empty()) {
    const std::string why = error ? error.message() : "no address";
    return fail("address '{}': host '{}' is not known ({}); check the spelling or give its IP address", text, parts->host, why);
  }
  const auto v4 = std::find_if(found.begin(), found.end(), [](const auto& e) { return e.endpoint().address().is_v4(); });
  const auto best = v4 != found.end() ? v4 : found.begin();
  return from_asio(best->endpoint().address(), parts->port);
}

std::string to_string(const Address& address) {
  return fmt::format(fmt::runtime(is_v4(address) ? "{}:{}" : "[{}]:{}"), to_asio(address).to_string(), address.port);
}

}  // namespace hapton
