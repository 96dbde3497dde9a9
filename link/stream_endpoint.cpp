#include "link/stream_endpoint.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>
#include <vector>

#include "link/address_endpoint.h"

namespace hapton {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kAcceptPauseNs = 100'000'000;  // if the process has no descriptor left
constexpr int kMaxAcceptsAtOnce = 8;                  // so that neither new connections nor datagrams keep the others waiting
constexpr int kMaxDatagramsAtOnce = 64;
constexpr int kSendBufferBytes = 128 * 1024;  // the kernel's share of the waiting data: older data is of no use
constexpr int kTriesForAPort = 32;            // to find one that is free for TCP and UDP
constexpr std::size_t kFirstConnection = 3;   // index in polled_: after waker, listening socket and datagrams

std::int64_t monotonic_ns() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecondNs + now.tv_nsec;
}

// A file descriptor that is closed with this object.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  int get() const { return number_; }

 private:
  int number_;
};

Descriptor make_socket(const Address& like, int type) {
  Descriptor socket(::socket(address_family(like), type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  // An IPv6 socket also serves IPv4, whatever the machine's default is.
  const int no = 0;
  if (socket.get() >= 0 && !is_v4(like)) ::setsockopt(socket.get(), IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
  return socket;
}

void set_option(const Descriptor& socket, int level, int name, int value) { ::setsockopt(socket.get(), level, name, &value, sizeof value); }

void prepare(const Descriptor& connection) {
  set_option(connection, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(connection, SOL_SOCKET, SO_SNDBUF, kSendBufferBytes);
  // A host that is switched off does not end its connection: keep-alive packets ask it for a reply, or the data that waits for it does.
  set_option(connection, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(connection, IPPROTO_TCP, TCP_KEEPIDLE, StreamEndpoint::kMaxSilentS / 2);
  set_option(connection, IPPROTO_TCP, TCP_KEEPINTVL, StreamEndpoint::kMaxSilentS / 4);
  set_option(connection, IPPROTO_TCP, TCP_USER_TIMEOUT, 1000 * StreamEndpoint::kMaxSilentS);
}

// Returns 0, or the system's errno.
int bind_to(const Descriptor& socket, const Address& address) {
  SocketAddress system = to_socket_address(address);
  return ::bind(socket.get(), system.get(), system.size) == 0 ? 0 : errno;
}

class SocketStreams final : public StreamEndpoint {
 public:
  // Returns 0, or the system's errno.
  int open(const Address& at);
  int open_to_connect();

  const Address& local_address() const override { return local_; }
  void wait(std::int64_t deadline_ns, Listener& listener) override;
  void wake() noexcept override;
  Id connect(const Address& to) override;
  bool send(Id id, std::span<const std::byte> bytes) override;
  bool send_datagram(const Address& to, std::span<const std::byte> bytes) override;
  void close(Id id) override;

 private:
  struct Connection {
    Id id = 0;
    Descriptor socket;
    Address peer;
    bool is_connecting = false;
    bool is_closing = false;
    std::vector<std::byte> waiting;
  };

  int open_at(const Address& at);
  Connection* find(Id id);
  std::size_t count_open() const;
  void poll_until(std::int64_t deadline_ns);
  void accept_some(Listener& listener);
  void receive_datagrams(Listener& listener);
  void serve(std::size_t index, short events, Listener& listener);
  void finish_connecting(Connection& connection, Listener& listener);
  void flush(Connection& connection);
  void receive(Id id, Listener& listener);
  void forget_closed(Listener& listener);

  Descriptor listening_, datagrams_, waker_;
  Address local_;
  std::vector<Connection> connections_;
  std::vector<pollfd> polled_;
  Id last_id_ = 0;
  std::int64_t accepts_from_ns_ = 0;  // no accept before this: the process had no descriptor left
  std::array<std::byte, 65536> buffer_;
};

int SocketStreams::open_at(const Address& at) {
  listening_ = make_socket(at, SOCK_STREAM);
  datagrams_ = make_socket(at, SOCK_DGRAM);
  if (listening_.get() < 0 || datagrams_.get() < 0) return errno;
  const int yes = 1;
  ::setsockopt(listening_.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (const int error = bind_to(listening_, at); error != 0) return error;
  SocketAddress bound;
  if (::getsockname(listening_.get(), bound.get(), &bound.size) != 0) return errno;
  local_ = at;
  local_.port = from_socket_address(bound).port;
  if (const int error = bind_to(datagrams_, local_); error != 0) return error;
  return ::listen(listening_.get(), SOMAXCONN) == 0 ? 0 : errno;
}

int SocketStreams::open_to_connect() {
  waker_ = Descriptor(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  return waker_.get() < 0 ? errno : 0;
}

int SocketStreams::open(const Address& at) {
  if (const int none = open_to_connect(); none != 0) return none;
  int error = open_at(at);
  for (int n = 1; at.port == 0 && error == EADDRINUSE && n < kTriesForAPort; ++n) error = open_at(at);
  return error;
}

SocketStreams::Connection* SocketStreams::find(Id id) {
  const auto found = std::find_if(connections_.begin(), connections_.end(), [&](const Connection& c) { return c.id == id; });
  return found != connections_.end() && !found->is_closing ? &*found : nullptr;
}

std::size_t SocketStreams::count_open() const {
  return static_cast<std::size_t>(
      std::count_if(connections_.begin(), connections_.end(), [](const Connection& c) { return !c.is_closing; }));
}

void SocketStreams::wake() noexcept {
  const std::uint64_t one = 1;
  // If the counter is full, the wait ends anyway.
  [[maybe_unused]] const ssize_t written = ::write(waker_.get(), &one, sizeof one);
}

StreamEndpoint::Id SocketStreams::connect(const Address& to) {
  if (count_open() >= kMaxConnections) return 0;
  Connection connection;
  connection.socket = make_socket(to, SOCK_STREAM);
  SocketAddress system = to_socket_address(to);
  if (connection.socket.get() < 0) return 0;
  if (::connect(connection.socket.get(), system.get(), system.size) != 0 && errno != EINPROGRESS) return 0;
  connection.id = ++last_id_;
  connection.peer = to;
  connection.is_connecting = true;
  connections_.push_back(std::move(connection));
  return last_id_;
}

bool SocketStreams::send(Id id, std::span<const std::byte> bytes) {
  Connection* connection = find(id);
  if (connection == nullptr) return false;
  if (connection->waiting.size() + bytes.size() > kMaxWaitingBytes) {
    connection->is_closing = true;
    return false;
  }
  connection->waiting.insert(connection->waiting.end(), bytes.begin(), bytes.end());
  if (!connection->is_connecting) flush(*connection);
  return !connection->is_closing;
}

bool SocketStreams::send_datagram(const Address& to, std::span<const std::byte> bytes) {
  if (is_v4(local_) && !is_v4(to)) return false;
  const SocketAddress system = is_v4(local_) ? to_socket_address(to) : to_v6_socket_address(to);
  return ::sendto(datagrams_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL, system.get(), system.size) >= 0;
}

void SocketStreams::close(Id id) {
  if (Connection* connection = find(id)) connection->is_closing = true;
}

void SocketStreams::flush(Connection& connection) {
  std::vector<std::byte>& waiting = connection.waiting;
  if (waiting.empty()) return;
  const ssize_t sent = ::send(connection.socket.get(), waiting.data(), waiting.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent > 0) waiting.erase(waiting.begin(), waiting.begin() + sent);
  if (sent < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) connection.is_closing = true;
}

void SocketStreams::poll_until(std::int64_t deadline_ns) {
  // ppoll ignores a negative descriptor.
  const bool may_accept = monotonic_ns() >= accepts_from_ns_;
  const auto all =
      std::to_array<pollfd>({{waker_.get(), POLLIN, 0}, {may_accept ? listening_.get() : -1, POLLIN, 0}, {datagrams_.get(), POLLIN, 0}});
  if (!may_accept) deadline_ns = std::min(deadline_ns, accepts_from_ns_);
  polled_.assign(all.begin(), all.end());
  bool is_one_closing = false;
  for (const Connection& connection : connections_) {
    const bool writes = connection.is_connecting || !connection.waiting.empty();
    polled_.push_back({connection.socket.get(), static_cast<short>(writes ? POLLIN | POLLOUT : POLLIN), 0});
    is_one_closing = is_one_closing || connection.is_closing;
  }
  const std::int64_t left_ns = is_one_closing ? 0 : std::max<std::int64_t>(0, deadline_ns - monotonic_ns());
  const timespec timeout = {.tv_sec = left_ns / kSecondNs, .tv_nsec = left_ns % kSecondNs};
  if (::ppoll(polled_.data(), polled_.size(), &timeout, nullptr) < 0) {
    for (pollfd& each : polled_) each.revents = 0;
  }
}

void SocketStreams::wait(std::int64_t deadline_ns, Listener& listener) {
  poll_until(deadline_ns);
  const std::size_t known = connections_.size();
  if (polled_[0].revents != 0) {
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t read = ::read(waker_.get(), &count, sizeof count);
  }
  for (std::size_t index = 0; index < known; ++index) serve(index, polled_[kFirstConnection + index].revents, listener);
  if (polled_[1].revents != 0) accept_some(listener);
  if (polled_[2].revents != 0) receive_datagrams(listener);
  forget_closed(listener);
}

void SocketStreams::serve(std::size_t index, short events, Listener& listener) {
  if (events == 0 || connections_[index].is_closing) return;
  const Id id = connections_[index].id;
  if (connections_[index].is_connecting) return finish_connecting(connections_[index], listener);
  if ((events & POLLOUT) != 0) flush(connections_[index]);
  if ((events & (POLLIN | POLLERR | POLLHUP)) != 0) receive(id, listener);
}

void SocketStreams::finish_connecting(Connection& connection, Listener& listener) {
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(connection.socket.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) {
    connection.is_closing = true;
    return;
  }
  prepare(connection.socket);
  connection.is_connecting = false;
  flush(connection);
  // The listener may open connections, which invalidates references to connections.
  const Id id = connection.id;
  const Address peer = connection.peer;
  listener.on_connected(id, peer);
}

// Receives at most one buffer, so that the other connections get their turn.
void SocketStreams::receive(Id id, Listener& listener) {
  Connection* connection = find(id);
  if (connection == nullptr) return;
  const ssize_t bytes = ::recv(connection->socket.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  if (bytes > 0) return listener.on_bytes(id, std::span(buffer_).first(static_cast<std::size_t>(bytes)));
  if (bytes == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) connection->is_closing = true;
}

void SocketStreams::accept_some(Listener& listener) {
  for (int n = 0; n < kMaxAcceptsAtOnce; ++n) {
    SocketAddress from;
    Descriptor socket(::accept4(listening_.get(), from.get(), &from.size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) {
      // Without a free descriptor the caller stays in the queue, and would end every wait at once.
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) accepts_from_ns_ = monotonic_ns() + kAcceptPauseNs;
      return;
    }
    if (count_open() >= kMaxConnections) {
      close(listener.choose_connection_to_evict());
      // Forgets it now: for the next caller the listener would choose the same connection again.
      forget_closed(listener);
      // A connection above the limit is closed silently.
      if (count_open() >= kMaxConnections) continue;
    }
    prepare(socket);
    Connection connection;
    connection.id = ++last_id_;
    connection.socket = std::move(socket);
    connection.peer = from_socket_address(from);
    const Address peer = connection.peer;
    connections_.push_back(std::move(connection));
    listener.on_connected(last_id_, peer);
  }
}

void SocketStreams::receive_datagrams(Listener& listener) {
  for (int n = 0; n < kMaxDatagramsAtOnce; ++n) {
    SocketAddress from;
    const ssize_t bytes = ::recvfrom(datagrams_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT, from.get(), &from.size);
    if (bytes < 0 && errno == ECONNREFUSED) continue;
    if (bytes < 0) return;
    listener.on_datagram(from_socket_address(from), std::span(buffer_).first(static_cast<std::size_t>(bytes)));
  }
}

void SocketStreams::forget_closed(Listener& listener) {
  std::vector<Id> closed;
  for (const Connection& connection : connections_) {
    if (connection.is_closing) closed.push_back(connection.id);
  }
  std::erase_if(connections_, [](const Connection& c) { return c.is_closing; });
  for (const Id id : closed) listener.on_closed(id);
}

}  // namespace

Result<std::unique_ptr<StreamEndpoint>> StreamEndpoint::open(std::string_view bind_address, std::uint16_t default_port) {
  const auto at = parse_address(bind_address, default_port);
  if (!at) return tl::unexpected(at.error());
  auto streams = std::make_unique<SocketStreams>();
  const int error = streams->open(*at);
  if (error == EADDRINUSE) {
    return fail("cannot listen on TCP and UDP {}: another program holds this port; stop it or choose another port", to_string(*at));
  }
  if (error == EADDRNOTAVAIL)
    return fail("cannot listen on TCP and UDP {}: this host has no such address; use one of its own", to_string(*at));
  if (error != 0) return fail("cannot listen on TCP and UDP {}: {}", to_string(*at), std::strerror(error));
  return streams;
}

Result<std::unique_ptr<StreamEndpoint>> StreamEndpoint::open_to_connect() {
  auto streams = std::make_unique<SocketStreams>();
  if (const int error = streams->open_to_connect(); error != 0) {
    return fail("cannot create an event descriptor: {}; allow the process more open files (ulimit -n)", std::strerror(error));
  }
  return streams;
}

}  // namespace hapton
