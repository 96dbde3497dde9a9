#include "link/udp_endpoint.h"

#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <cerrno>
#include <ctime>
#include <limits>
#include <optional>

#include "link/address_endpoint.h"
#include "link/asio_guard.h"
#include "link/flood_filter.h"
#include "link/source_filter.h"

namespace hapton {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kNothingPrepared = std::numeric_limits<std::int64_t>::min();
// A receive blocks this long at most (plus a scheduler tick or two), so it cannot miss a deadline that is farther away than kFarNs.
constexpr std::int64_t kBlockingNs = 8'000'000;
constexpr std::int64_t kFarNs = 20'000'000;
// Foreign datagrams that one receive skips after its deadline, so that a flood cannot hold it up.
constexpr int kMaxPassedOver = 64;
constexpr int kReceiveBufferBytes = 1 << 20;  // a choice: how much a node that was paused can still read

std::int64_t monotonic_ns() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecondNs + now.tv_nsec;
}

class UdpEndpoint final : public Endpoint {
 public:
  explicit UdpEndpoint(bool filters_floods) : socket_(context_), filters_floods_(filters_floods) {}
  ~UdpEndpoint() override;

  error_code open(const udp::endpoint& local);

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  void prepare_wait(std::int64_t deadline_ns) noexcept override;
  Address local_address() const override { return local_; }
  bool accept_only(const Address& peer) noexcept override;
  void expect(const Address& from, std::uint32_t connection) noexcept override {
    if (filters_floods_) filter_.note_expected(from, connection, monotonic_ns());
  }
  SocketCounts socket_counts() const noexcept override { return filter_.counts(); }

 private:
  enum class Attempt : std::uint8_t {
    received,
    passed_over,  // no datagram of Hapton: it was empty or too long, or an error said that a peer is not there
    nothing,
  };

  // A timer that prepare_wait has set, and the deadline for which it is set.
  struct Timer {
    int file = -1;
    std::int64_t deadline_ns = kNothingPrepared;
  };

  std::optional<udp::endpoint> remote(const Address& to) const noexcept;
  const Timer* find_timer(std::int64_t deadline_ns) const noexcept;
  bool wait_readable(std::int64_t deadline_ns) noexcept;
  bool wait_readable_prepared(const Timer& timer) noexcept;
  void update_filter(std::int64_t now_ns) noexcept;
  std::uint32_t read_dropped() const noexcept;
  Attempt try_receive(std::span<std::byte> into, int flags, Received& received) noexcept;

  asio::io_context context_;
  udp::socket socket_;
  Address local_;
  bool is_v4_ = true;
  std::array<Timer, 2> timers_;
  std::size_t next_timer_ = 0;
  bool filters_floods_;
  FloodFilter filter_;
};

UdpEndpoint::~UdpEndpoint() {
  for (const Timer& timer : timers_) {
    if (timer.file >= 0) close(timer.file);
  }
}

error_code UdpEndpoint::open(const udp::endpoint& local) {
  for (Timer& timer : timers_) {
    timer.file = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    if (timer.file < 0) return {errno, boost::system::system_category()};
  }
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
  // The kernel may grant less; that only limits how long a paused node can catch up.
  socket_.set_option(asio::socket_base::receive_buffer_size(kReceiveBufferBytes), error);
  socket_.bind(local, error);
  if (error) {
    return error;
  }
  constexpr timeval kLimit = {.tv_sec = 0, .tv_usec = kBlockingNs / 1000};
  if (setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &kLimit, sizeof kLimit) != 0) {
    return {errno, boost::system::system_category()};
  }
  const udp::endpoint bound = socket_.local_endpoint(error);
  if (!error) {
    local_ = from_endpoint(bound);
  }
  return error;
}

std::optional<udp::endpoint> UdpEndpoint::remote(const Address& to) const noexcept {
  if (is_v4_) {
    return is_v4(to) ? std::optional(to_endpoint<udp::endpoint>(to)) : std::nullopt;
  }
  return udp::endpoint(asio::ip::address_v6(to.ip), to.port);
}

bool UdpEndpoint::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  const std::optional<udp::endpoint> endpoint = remote(to);
  if (!endpoint || datagram.size() > kMaxDatagramBytes) {
    return false;
  }
  // If an earlier datagram was refused, the next call reports it; that says nothing about this datagram: try again.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (sendto(socket_.native_handle(), datagram.data(), datagram.size(), MSG_DONTWAIT, endpoint->data(),
               static_cast<socklen_t>(endpoint->size())) >= 0) {
      if (filters_floods_) filter_.note_sent(to, datagram, monotonic_ns());
      return true;
    }
    if (errno != ECONNREFUSED) {
      return false;
    }
  }
  return false;
}

void UdpEndpoint::prepare_wait(std::int64_t deadline_ns) noexcept {
  if (deadline_ns <= 0) {
    return;
  }
  const itimerspec once = {.it_interval = {}, .it_value = {.tv_sec = deadline_ns / kSecondNs, .tv_nsec = deadline_ns % kSecondNs}};
  Timer& timer = timers_[next_timer_];
  next_timer_ = (next_timer_ + 1) % timers_.size();
  // On failure receive sets its own timer, as it does for a deadline that was not prepared.
  timer.deadline_ns = timerfd_settime(timer.file, TFD_TIMER_ABSTIME, &once, nullptr) == 0 ? deadline_ns : kNothingPrepared;
}

const UdpEndpoint::Timer* UdpEndpoint::find_timer(std::int64_t deadline_ns) const noexcept {
  const auto found = std::find_if(timers_.begin(), timers_.end(), [&](const Timer& timer) { return timer.deadline_ns == deadline_ns; });
  return found == timers_.end() ? nullptr : &*found;
}

bool UdpEndpoint::wait_readable_prepared(const Timer& timer) noexcept {
  std::array<pollfd, 2> waited_for = {
      {{.fd = socket_.native_handle(), .events = POLLIN, .revents = 0}, {.fd = timer.file, .events = POLLIN, .revents = 0}}};
  while (ppoll(waited_for.data(), waited_for.size(), nullptr, nullptr) <= 0) {
  }
  return waited_for[0].revents != 0;
}

bool UdpEndpoint::wait_readable(std::int64_t deadline_ns) noexcept {
  if (const Timer* timer = find_timer(deadline_ns); timer != nullptr) return wait_readable_prepared(*timer);
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
    // EINTR, and ENOMEM under memory pressure: wait for the rest of the time.
  }
}

UdpEndpoint::Attempt UdpEndpoint::try_receive(std::span<std::byte> into, int flags, Received& received) noexcept {
  udp::endpoint from;
  auto from_size = static_cast<socklen_t>(from.capacity());
  const ssize_t bytes = recvfrom(socket_.native_handle(), into.data(), into.size(), flags | MSG_TRUNC, from.data(), &from_size);
  if (bytes < 0) {
    return errno == ECONNREFUSED ? Attempt::passed_over : Attempt::nothing;
  }
  const Address sender = from_endpoint(from);
  // With MSG_TRUNC recvfrom returns the full size of a datagram longer than the buffer; Hapton's nodes send none.
  const bool is_oversized = bytes == 0 || static_cast<std::size_t>(bytes) > into.size();
  filter_.note_received(sender, into.first(std::min(static_cast<std::size_t>(bytes), into.size())), is_oversized);
  if (is_oversized) return Attempt::passed_over;
  received = {.bytes = static_cast<std::size_t>(bytes), .from = sender};
  return Attempt::received;
}

std::uint32_t UdpEndpoint::read_dropped() const noexcept {
  std::array<std::uint32_t, SK_MEMINFO_VARS> info = {};
  socklen_t size = sizeof info;
  const int file = const_cast<udp::socket&>(socket_).native_handle();
  return getsockopt(file, SOL_SOCKET, SO_MEMINFO, info.data(), &size) == 0 ? info[SK_MEMINFO_DROPS] : 0;
}

void UdpEndpoint::update_filter(std::int64_t now_ns) noexcept {
  const FloodFilter::Action action = filter_.end_period(read_dropped(), now_ns);
  if (action == FloodFilter::Action::install) {
    const auto program = filter_.program();
    const sock_fprog attached = {.len = static_cast<std::uint16_t>(program.size()), .filter = program.data()};
    // If this fails (no memory), the limits on datagrams per receive still bound the cost of a flood.
    (void)setsockopt(socket_.native_handle(), SOL_SOCKET, SO_ATTACH_FILTER, &attached, sizeof attached);
  } else if (action == FloodFilter::Action::remove) {
    const int unused = 0;
    (void)setsockopt(socket_.native_handle(), SOL_SOCKET, SO_DETACH_FILTER, &unused, sizeof unused);
  }
}

bool UdpEndpoint::accept_only(const Address& peer) noexcept {
  SourceFilter filter(peer);
  const auto program = filter.program();
  const sock_fprog attached = {.len = static_cast<std::uint16_t>(program.size()), .filter = program.data()};
  return setsockopt(socket_.native_handle(), SOL_SOCKET, SO_ATTACH_FILTER, &attached, sizeof attached) == 0;
}

Received UdpEndpoint::receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept {
  // There are three ways to wait; this uses the cheapest that suffices. While the deadline is far: in recvfrom, which sets no precise timer
  // and is one system call. When the deadline is near: by ppoll. When it has passed: not at all.
  std::int64_t now_ns = monotonic_ns();
  if (filters_floods_ && filter_.is_due(now_ns)) update_filter(now_ns);
  for (int passed_over = 0; passed_over < kMaxPassedOver; now_ns = monotonic_ns()) {
    const bool is_deadline_far = now_ns + kFarNs < deadline_ns && find_timer(deadline_ns) == nullptr;
    const bool is_deadline_past = deadline_ns <= now_ns;
    // After a wait that found nothing, no other system call is needed.
    if (!is_deadline_past && !is_deadline_far && !wait_readable(deadline_ns)) return {};
    Received received;
    const Attempt attempt = try_receive(into, is_deadline_far ? 0 : MSG_DONTWAIT, received);
    if (attempt == Attempt::received || (attempt == Attempt::nothing && is_deadline_past)) {
      return received;
    }
    passed_over += is_deadline_past ? 1 : 0;
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<Endpoint>> open_udp_endpoint(std::string_view bind_address, bool filters_floods) {
  const Result<Address> local = parse_address(bind_address);
  if (!local) {
    return tl::unexpected(local.error());
  }
  const udp::endpoint local_endpoint = to_endpoint<udp::endpoint>(*local);
  auto made = make_with_context<UdpEndpoint>(filters_floods);
  if (!made) return fail("cannot listen on UDP {}: {}", to_string(*local), made.error().what);
  std::unique_ptr<UdpEndpoint>& endpoint = *made;
  const error_code error = endpoint->open(local_endpoint);
  if (error == asio::error::address_in_use) {
    return fail("cannot listen on UDP {}: another program holds this port; stop it or choose another port with --bind", to_string(*local));
  }
  if (error == boost::system::errc::address_not_available) {
    return fail("cannot listen on UDP {}: this host has no such address; use one of its own, or 0.0.0.0 for all", to_string(*local));
  }
  if (error == boost::system::errc::too_many_files_open) {
    return fail("cannot listen on UDP {}: {}; allow the process more open files (ulimit -n, LimitNOFILE)", to_string(*local),
                error.message());
  }
  if (error) {
    return fail("cannot listen on UDP {}: {}", to_string(*local), error.message());
  }
  return std::move(endpoint);
}

}  // namespace hapton
