#include "io_node/vrpn/vrpn_server.h"

#include <sys/resource.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <utility>

#include "link/link_key.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton::vrpn {
namespace {

constexpr std::int64_t kIdleNs = 100 * kNanosecondsPerMillisecond;    // longest wait without clients; a choice
constexpr std::int64_t kCookieTimeoutNs = 5 * kNanosecondsPerSecond;  // for the cookie, the first bytes of a client; a choice
constexpr std::int32_t kButtons = 32;                                 // the bits of DeviceSample::buttons
constexpr std::int32_t kMiscellaneousError = 3, kNoError = 4;         // values of vrpn_ForceDevice's Force_Error message
constexpr int kNiceness = 10;                                         // lower priority than servo and haptics node, which may share its CPU
constexpr double kSlowestHz = 0.1;                                    // a client that requests a lower report rate gets this; a choice

// VRPN stamps its messages with the time of day.
Time to_time_of_day(std::int64_t monotonic_ns) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::int64_t us =
      std::chrono::duration_cast<std::chrono::microseconds>(now).count() + (monotonic_ns - SteadyClock().now_ns()) / 1000;
  return {static_cast<std::uint32_t>(us / 1'000'000), static_cast<std::uint32_t>(us % 1'000'000)};
}

// Whether `text` is the numeric address of the peer. Host names are not resolved.
bool is_own_address(const std::string& text, const Address& peer) {
  const std::string with_port = to_string(peer);
  const std::string port = ":" + std::to_string(peer.port);
  return with_port == text + port || with_port == "[" + text + "]" + port;
}

// The port of "HOST PORT\0", which a client sends in a datagram to request a TCP connection to itself. The host is ignored: only the sender
// of the datagram is connected to, because otherwise anyone could make this server connect to any host.
std::optional<std::uint16_t> callback_port(std::span<const std::byte> bytes) {
  constexpr std::size_t kLongest = 200;
  constexpr int kLowest = 1024;
  if (bytes.size() > kLongest) return std::nullopt;
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  text = text.substr(0, text.find('\0'));
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos || space == 0) return std::nullopt;
  const std::string_view digits = text.substr(space + 1);
  int port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || end != digits.data() + digits.size() || port < kLowest || port > 65535) return std::nullopt;
  return static_cast<std::uint16_t>(port);
}

}  // namespace

struct Server::State final : StreamEndpoint::Listener {
  struct Peer {
    explicit Peer(std::string_view name) : client(name) {}
    Client client;
    Address address;
    std::int64_t since_ns = 0;
    bool is_open = false;      // its TCP connection is open
    bool is_reported = false;  // the log has a line about it
    bool has_states = false;   // it was sent the states of buttons and device, so changes may follow
    bool is_rejection_logged = false;
    bool is_touching = false;  // the last contact message to it reported contact
    std::int64_t next_report_ns = 0;
    std::optional<Address> udp;
  };

  State(Feed& feed_in, Options options_in, std::unique_ptr<StreamEndpoint> endpoint_in)
      : feed(feed_in), options(std::move(options_in)), endpoint(std::move(endpoint_in)) {}

  void run();
  void on_connected(StreamEndpoint::Id id, const Address& peer) override;
  void on_bytes(StreamEndpoint::Id id, std::span<const std::byte> bytes) override;
  void on_closed(StreamEndpoint::Id id) override;
  void on_datagram(const Address& from, std::span<const std::byte> bytes) override;
  StreamEndpoint::Id choose_connection_to_evict() override;

  void reply(StreamEndpoint::Id id, Peer& peer);
  void follow_udp_request(Peer& peer);
  void drop_timed_out(std::int64_t now_ns);
  void take_samples();
  void report();
  void show_states(Client& client, Time time) const;
  void report_to(Peer& peer, Time time);
  bool is_due(Peer& peer) const;
  template <class Append>
  void append_to_reporting_clients(OurType type, Append&& append);
  bool has_client() const {
    return std::any_of(peers.begin(), peers.end(), [](const auto& peer) { return peer.second.client.is_connected(); });
  }

  Feed& feed;
  const Options options;
  std::unique_ptr<StreamEndpoint> endpoint;
  SteadyClock clock;
  std::map<StreamEndpoint::Id, Peer> peers;
  std::optional<FeedSample> newest, sent;
  std::optional<FeedProxy> proxy;
  Vec3 v_m_per_s = Vec3::Zero();
  Quat turn = Quat::Identity();
  double dt_s = 0.0;
  std::atomic<bool> ends{false};
  std::thread thread;
};

void Server::State::run() {
  ::setpriority(PRIO_PROCESS, 0, kNiceness);
  const auto period_ns = static_cast<std::int64_t>(1e9 / options.rate_hz);
  std::int64_t next_ns = clock.now_ns();
  while (!ends.load(std::memory_order_relaxed)) {
    const bool has_clients = has_client();
    feed.set_wanted(has_clients);
    if (!has_clients) {
      newest = sent = std::nullopt;
      proxy.reset();
    }
    endpoint->wait(has_clients ? next_ns : clock.now_ns() + kIdleNs, *this);
    const std::int64_t now_ns = clock.now_ns();
    drop_timed_out(now_ns);
    if (now_ns < next_ns) continue;
    next_ns = std::max(next_ns + period_ns, now_ns);
    take_samples();
    report();
  }
}

void Server::State::on_connected(StreamEndpoint::Id id, const Address& address) {
  auto& peer = peers.try_emplace(id, options.name).first->second;
  peer.address = address;
  peer.since_ns = clock.now_ns();
  peer.is_open = true;
  reply(id, peer);
}

void Server::State::on_bytes(StreamEndpoint::Id id, std::span<const std::byte> bytes) {
  const auto found = peers.find(id);
  if (found == peers.end()) return;
  Peer& peer = found->second;
  if (!peer.client.receive(bytes, to_time_of_day(clock.now_ns()))) {
    endpoint->close(id);
    return;
  }
  if (peer.client.is_connected() && !std::exchange(peer.is_reported, true)) {
    log_info("a VRPN client at {} reads {}", to_string(peer.address), options.name);
  }
  if (peer.client.rejected_forces() > 0 && !std::exchange(peer.is_rejection_logged, true)) {
    log_warning("the VRPN client at {} requests forces; rejected: only the haptics node sends forces", to_string(peer.address));
  }
  follow_udp_request(peer);
  if (peer.client.take_workspace_request()) {
    append_workspace(peer.client.out(), peer.client.header(OurType::workspace, to_time_of_day(clock.now_ns())),
                     options.limits.workspace_min_m, options.limits.workspace_max_m);
  }
  reply(id, peer);
}

// Datagrams go only to the host of the connection.
void Server::State::follow_udp_request(Peer& peer) {
  if (!peer.client.udp_request() || peer.udp) return;
  if (!is_own_address(peer.client.udp_request()->address, peer.address)) return;
  peer.udp = peer.address;
  peer.udp->port = peer.client.udp_request()->port;
}

void Server::State::reply(StreamEndpoint::Id id, Peer& peer) {
  if (peer.client.out().empty()) return;
  endpoint->send(id, peer.client.out());
  peer.client.out().clear();
}

void Server::State::on_closed(StreamEndpoint::Id id) {
  const auto found = peers.find(id);
  if (found == peers.end()) return;
  if (found->second.is_reported) log_info("the VRPN client at {} left", to_string(found->second.address));
  peers.erase(found);
}

void Server::State::on_datagram(const Address& from, std::span<const std::byte> bytes) {
  const auto port = callback_port(bytes);
  if (!port) return;
  Address to = from;
  to.port = *port;
  // A client repeats the request until it is connected.
  const bool is_there = std::any_of(peers.begin(), peers.end(), [&](const auto& peer) { return peer.second.address == to; });
  if (is_there) return;
  // Makes room as for a client that connects by TCP.
  if (peers.size() >= StreamEndpoint::kMaxConnections) endpoint->close(choose_connection_to_evict());
  if (const StreamEndpoint::Id id = endpoint->connect(to); id != 0) {
    auto& peer = peers.try_emplace(id, options.name).first->second;
    peer.address = to;
    peer.since_ns = clock.now_ns();
  }
}

// The oldest of the clients that have sent no cookie, to be closed: 16 such clients must not keep all others out.
StreamEndpoint::Id Server::State::choose_connection_to_evict() {
  StreamEndpoint::Id longest = 0;
  std::int64_t since_ns = 0;
  for (const auto& [id, peer] : peers) {
    if (peer.client.is_connected() || (longest != 0 && peer.since_ns >= since_ns)) continue;
    longest = id;
    since_ns = peer.since_ns;
  }
  return longest;
}

// Closes clients that have not sent a cookie in time.
void Server::State::drop_timed_out(std::int64_t now_ns) {
  for (const auto& [id, peer] : peers) {
    if (!peer.client.is_connected() && now_ns - peer.since_ns > kCookieTimeoutNs) endpoint->close(id);
  }
}

template <class Append>
void Server::State::append_to_reporting_clients(OurType type, Append&& append) {
  const Time time = to_time_of_day(newest->device.time_ns);
  for (auto& [id, peer] : peers) {
    if (peer.has_states) append(peer.client.out(), peer.client.header(type, time));
  }
}

// Sends every change of a button and of the error state; of everything else report() sends only the newest state.
void Server::State::take_samples() {
  feed.take([&](const FeedSample& sample) {
    const std::uint32_t before = newest ? newest->device.buttons : 0;
    const bool had_error = newest && newest->status != DeviceStatus::ready;
    newest = sample;
    for (std::int32_t n = 0; n < kButtons; ++n) {
      const std::uint32_t bit = std::uint32_t{1} << n;
      if (((before ^ sample.device.buttons) & bit) == 0) continue;
      append_to_reporting_clients(OurType::button_change, [&](Bytes& out, const Header& header) {
        append_button_change(out, header, n, (sample.device.buttons & bit) != 0);
      });
    }
    const bool has_error = sample.status != DeviceStatus::ready;
    if (has_error == had_error) return;
    append_to_reporting_clients(OurType::force_error, [&](Bytes& out, const Header& header) {
      append_force_error(out, header, has_error ? kMiscellaneousError : kNoError);
    });
  });
}

// A client may ask for fewer reports than the others get.
bool Server::State::is_due(Peer& peer) const {
  const std::optional<double> wanted_hz = peer.client.wanted_rate_hz();
  if (!wanted_hz || *wanted_hz >= options.rate_hz) return true;
  const std::int64_t now_ns = newest->device.time_ns;
  if (now_ns < peer.next_report_ns) return false;
  const auto period_ns = static_cast<std::int64_t>(1e9 / std::max(*wanted_hz, kSlowestHz));
  peer.next_report_ns = std::max(peer.next_report_ns + period_ns, now_ns);
  return true;
}

void Server::State::report() {
  if (FeedProxy shown; feed.take_proxy(shown)) proxy = shown;
  const bool is_new = newest && (!sent || newest->device.time_ns != sent->device.time_ns);
  // The pose of a device that is disconnected or not calibrated is unknown.
  const bool is_known = is_new && newest->status == DeviceStatus::ready;
  if (is_known && sent && sent->status == DeviceStatus::ready) {
    dt_s = 1e-9 * static_cast<double>(newest->device.time_ns - sent->device.time_ns);
    v_m_per_s = dt_s > 0.0 ? Vec3((newest->device.p_WD - sent->device.p_WD) / dt_s) : Vec3::Zero();
    turn = (newest->device.q_WT * sent->device.q_WT.conjugate()).normalized();
  } else if (is_new) {
    dt_s = 0.0;
    v_m_per_s = Vec3::Zero();
    turn = Quat::Identity();
  }
  const Time time = newest ? to_time_of_day(newest->device.time_ns) : Time{};
  for (auto& [id, peer] : peers) {
    if (!peer.is_open) continue;
    if (newest && peer.client.is_connected() && !std::exchange(peer.has_states, true)) show_states(peer.client, time);
    if (is_known && peer.client.is_connected() && is_due(peer)) report_to(peer, time);
    reply(id, peer);
  }
  if (is_new) sent = newest;
}

// The present states of which later only changes are sent: buttons and error. Without an error there is nothing to send about it.
void Server::State::show_states(Client& client, Time time) const {
  append_button_states(client.out(), client.header(OurType::button_states, time), newest->device.buttons, kButtons);
  if (newest->status == DeviceStatus::ready) return;
  append_force_error(client.out(), client.header(OurType::force_error, time), kMiscellaneousError);
}

void Server::State::report_to(Peer& peer, Time time) {
  Client& client = peer.client;
  Bytes datagram;
  Bytes& out = peer.udp ? datagram : client.out();
  const Vec3 &f = newest->wrench.force_n, &t = newest->wrench.torque_nm;
  const std::array<double, 7> channels = {f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), newest->motor_temperature};
  append_position(out, client.header(OurType::position, time), kStylus, newest->device.p_WD, newest->device.q_WT);
  if (proxy) append_position(out, client.header(OurType::position, time), kProxy, proxy->p_WP, proxy->q_WP);
  append_velocity(out, client.header(OurType::velocity, time), v_m_per_s, turn, dt_s);
  append_force(out, client.header(OurType::force, time), f);
  append_analog(out, client.header(OurType::analog, time), channels);
  // The end of contact is reported once.
  if (proxy && (proxy->is_contact || std::exchange(peer.is_touching, false))) {
    append_contact_point(out, client.header(OurType::contact_point, time), proxy->p_WP, proxy->q_WP, proxy->is_contact);
    peer.is_touching = proxy->is_contact;
  }
  // A lost datagram is not repeated: the next one follows soon.
  if (peer.udp) endpoint->send_datagram(*peer.udp, datagram);
}

Result<std::unique_ptr<Server>> Server::open(Feed& feed, const Options& options) {
  constexpr std::size_t kLongestName = 64;
  const bool is_name_good = !options.name.empty() && options.name.size() <= kLongestName &&
                            std::all_of(options.name.begin(), options.name.end(),
                                        [](unsigned char letter) { return std::isalnum(letter) != 0 || letter == '_' || letter == '-'; });
  if (!is_name_good) return fail("'{}' is not a valid VRPN device name; use letters, digits, '-' and '_'", options.name);
  auto endpoint = StreamEndpoint::open(options.address, kPort);
  if (!endpoint) return tl::unexpected(endpoint.error());
  const Address at = (*endpoint)->local_address();
  log_info("VRPN: {}@{}", options.name, to_string(at));
  if (!is_loopback(at)) {
    log_warning(
        "VRPN has no authentication: anyone who reaches {} can read the hand's position; bind it to 127.0.0.1 or to a private network",
        to_string(at));
  }
  auto state = std::make_unique<State>(feed, options, std::move(*endpoint));
  State& running = *state;
  state->thread = start_thread([&running] { running.run(); });
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() {
  state_->ends.store(true, std::memory_order_relaxed);
  state_->endpoint->wake();
  state_->thread.join();
  state_->feed.set_wanted(false);
}

const Address& Server::local_address() const { return state_->endpoint->local_address(); }

}  // namespace hapton::vrpn
