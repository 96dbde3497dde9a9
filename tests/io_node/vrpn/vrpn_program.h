#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "link/endpoint.h"
#include "vrpn/vrpn_wire.h"

namespace hapton::vrpn {

// A VRPN client that acts like VRPN's own client library and connects in either way. Nothing blocks: poll() receives what has arrived.
class Program {
 public:
  // A received message: its name, its body, and whether it came by UDP. received() has the newest last.
  struct Received {
    std::string name;
    Bytes body;
    bool by_udp = false;
  };

  Program() { append_cookie(out_); }
  ~Program() {
    for (const int socket : {tcp_, listening_, udp_}) {
      if (socket >= 0) ::close(socket);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Connects by TCP, as for "name@tcp://host".
  void connect(const Address& server, int receive_buffer_bytes = 0) {
    tcp_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (receive_buffer_bytes > 0) ::setsockopt(tcp_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
    const sockaddr_in to = loopback(server.port);
    if (::connect(tcp_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) is_closed_ = true;
  }

  // Sends a datagram that requests a TCP connection from the server, as for "name@host".
  void request_callbacks(const Address& server, const std::string& host = "127.0.0.1") {
    listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const std::uint16_t port = bind_to_any(listening_);
    ::listen(listening_, 1);
    send_datagram(server, host + " " + std::to_string(port));
  }
  void send_datagram(const Address& server, const std::string& text) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const sockaddr_in to = loopback(server.port);
    ::sendto(socket, text.c_str(), text.size() + 1, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    ::close(socket);
  }

  // Tells the server where to send datagrams.
  void describe_udp(const std::string& host = "127.0.0.1") {
    udp_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const std::uint16_t port = bind_to_any(udp_);
    Bytes message;
    append_empty(message, {port, kUdpDescription, {}, 0});
    const std::size_t length = message.size() + host.size() + 1;
    message[3] = static_cast<std::byte>(length);
    for (const char letter : host) message.push_back(static_cast<std::byte>(letter));
    message.resize((length + 7) / 8 * 8);
    say(message);
  }
  void describe_sender(std::int32_t id, const std::string& name) { describe(kSenderDescription, id, name); }
  void describe_type(std::int32_t id, const std::string& name) { describe(kTypeDescription, id, name); }
  void say(std::int32_t sender, std::int32_t type) {
    Bytes message;
    append_empty(message, {sender, type, {}, 0});
    say(message);
  }
  void say(const Bytes& bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }

  // Sends pending messages and takes those received.
  void poll() {
    if (tcp_ < 0 && listening_ >= 0 && is_readable(listening_)) tcp_ = ::accept(listening_, nullptr, nullptr);
    if (tcp_ >= 0 && !out_.empty()) {
      const ssize_t sent = ::send(tcp_, out_.data(), out_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) out_.erase(out_.begin(), out_.begin() + sent);
    }
    take_tcp();
    take_udp();
  }

  bool is_connected() const { return tcp_ >= 0; }
  bool is_closed() const { return is_closed_; }
  const std::vector<Received>& received() const { return received_; }
  bool has_received(const std::string& name) const {
    return std::any_of(received_.begin(), received_.end(), [&](const Received& h) { return h.name == name; });
  }
  const Received* last(const std::string& name) const {
    const auto found = std::find_if(received_.rbegin(), received_.rend(), [&](const Received& h) { return h.name == name; });
    return found != received_.rend() ? &*found : nullptr;
  }
  void forget() { received_.clear(); }
  const std::string& device() const { return device_; }

 private:
  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }
  static std::uint16_t bind_to_any(int socket) {
    sockaddr_in at = loopback(0);
    socklen_t size = sizeof at;
    ::bind(socket, reinterpret_cast<const sockaddr*>(&at), size);
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size);
    return ntohs(at.sin_port);
  }
  static bool is_readable(int socket) {
    pollfd one = {socket, POLLIN, 0};
    return ::poll(&one, 1, 0) > 0;
  }
  void describe(std::int32_t kind, std::int32_t id, const std::string& name) {
    Bytes message;
    append_description(message, kind, id, name, {}, 0);
    say(message);
  }

  void take_tcp() {
    std::array<std::byte, 65536> buffer;
    while (tcp_ >= 0 && !is_closed_ && is_readable(tcp_)) {
      const ssize_t bytes = ::recv(tcp_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (bytes <= 0) {
        is_closed_ = true;
        return;
      }
      in_.insert(in_.end(), buffer.begin(), buffer.begin() + bytes);
    }
    if (!has_cookie_) {
      if (in_.size() < kCookieBytes) return;
      has_cookie_ = is_cookie_good(std::span(in_).first(kCookieBytes));
      if (!has_cookie_) is_closed_ = true;
      in_.erase(in_.begin(), in_.begin() + kCookieBytes);
    }
    std::span<const std::byte> rest(in_);
    take_messages(rest, false);
    in_.erase(in_.begin(), in_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  }
  void take_udp() {
    std::array<std::byte, 2048> buffer;
    while (udp_ >= 0 && is_readable(udp_)) {
      const ssize_t bytes = ::recv(udp_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (bytes <= 0) return;
      std::span<const std::byte> rest(buffer.data(), static_cast<std::size_t>(bytes));
      take_messages(rest, true);
    }
  }
  void take_messages(std::span<const std::byte>& rest, bool by_udp) {
    Message message;
    while (read_message(rest, message) == ReadStatus::message) {
      if (message.type == kSenderDescription) device_ = name_of(message);
      if (message.type == kTypeDescription) types_[message.sender] = name_of(message);
      if (message.type >= 0) received_.push_back({types_[message.type], Bytes(message.body.begin(), message.body.end()), by_udp});
    }
  }

  int tcp_ = -1, listening_ = -1, udp_ = -1;
  Bytes out_, in_;
  bool has_cookie_ = false;
  bool is_closed_ = false;
  std::string device_;
  std::map<std::int32_t, std::string> types_;
  std::vector<Received> received_;
};

}  // namespace hapton::vrpn
