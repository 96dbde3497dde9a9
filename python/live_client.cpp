#include "python/live_client.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "runtime/start_thread.h"

namespace hapton::python {
namespace {

constexpr double kClientJoinTimeoutS = 5.0;
constexpr std::int64_t kClientTurnNs = kNanosecondsPerMillisecond;  // longest time that a marker waits before it is sent
constexpr std::size_t kMaxCarves = 1'000'000;                       // the limit of Sculpture
constexpr auto kMoveTimeout = std::chrono::seconds(3);
constexpr double kShapeTimeoutS = 5.0;
constexpr std::int64_t kViewEveryNs = 50 * kNanosecondsPerMillisecond;  // repeated until the forces use it: a datagram may be lost

}  // namespace

Result<std::unique_ptr<LiveClient>> LiveClient::open(const std::string& hub, const std::string& key_file) {
  const HubConnection::Settings settings{.hub = hub, .key_file = key_file};
  auto connection = HubConnection::open(NodeRole::vision, settings);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kClientJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  return std::unique_ptr<LiveClient>(new LiveClient(std::move(*connection), settings));
}

LiveClient::LiveClient(std::unique_ptr<HubConnection> connection, HubConnection::Settings settings)
    : settings_(std::move(settings)), connection_(std::move(connection)) {
  thread_ = start_thread([this] { run(); });
}

LiveClient::~LiveClient() { stop(); }

void LiveClient::stop() {
  is_stopping_.store(true);
  const std::scoped_lock lock(stop_mutex_);
  if (thread_.joinable()) thread_.join();
  connection_.reset();
  is_joined_.store(false);
}

std::optional<ProbeState> LiveClient::newest() {
  const std::scoped_lock lock(mutex_);
  return newest_;
}

Result<std::uint32_t> LiveClient::turn_scene(const std::array<float, 12>& X_WS) {
  if (is_stopping_.load()) return fail("this client is closed");
  // The new revision follows the one in use, which the first ProbeState reports.
  for (int ms = 0; ms < 1000 && !newest(); ++ms) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const std::scoped_lock lock(mutex_);
  view_.X_WS = X_WS;
  view_.revision = std::max({view_.revision, others_view_.revision(), newest_ ? newest_->view_revision : 0U});
  return ++view_.revision;
}

Result<std::uint64_t> LiveClient::mark(std::string_view text) {
  if (is_stopping_.load()) return fail("this client is closed");
  return request_mark(markers_, text);
}

Result<double> LiveClient::move_object(std::string_view object, const MoveTarget& target) {
  const auto request = make_move_request(object, target);
  if (!request) return tl::unexpected(request.error());
  if (is_stopping_.load()) return fail("this client is closed");
  const auto reply = moves_.request(*request, kMoveTimeout);
  if (!reply) return fail("no haptics node replied in {} s; start haptics_node; an earlier version does not reply", kMoveTimeout.count());
  if (reply->rejection[0] == '\0' && !object.starts_with('#')) {
    const std::scoped_lock lock(mutex_);
    known_moves_.note_name(object, reply->object);
  }
  return read_reply(*reply);
}

Result<double> LiveClient::set_shape(std::string_view object, std::span<const ShapePart::Displacement> displacements_m, double over_s,
                                     bool waits) {
  if (is_stopping_.load()) return fail("this client is closed");
  const auto shape = shapes_.give(object, displacements_m, over_s, waits);
  if (!shape) return tl::unexpected(shape.error());
  return waits ? shapes_.wait_for(*shape, kShapeTimeoutS) : Result<double>(0.0);
}

std::string LiveClient::take_shape_rejection() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(shape_rejection_, {});
}

void LiveClient::take_shape_reply(const Message& message) {
  shapes_.take(message);
  const auto* reply = std::get_if<ShapeReply>(&message);
  if (reply == nullptr || reply->rejection[0] == '\0') return;
  const std::scoped_lock lock(mutex_);
  shape_rejection_ = reply->rejection.data();
}

Result<std::string> LiveClient::set(const SettingsChange& change, const std::string& key_file) {
  const auto request = make_settings_request(change);
  if (!request) return tl::unexpected(request.error());
  if (is_stopping_.load()) return fail("this client is closed");
  const auto tool =
      HubConnection::open(NodeRole::tool, {.hub = settings_.hub, .key_file = key_file.empty() ? settings_.key_file : key_file});
  if (!tool) return tl::unexpected(tool.error());
  if (const auto joined = (*tool)->wait_until_joined(kClientJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  return apply_settings((*tool)->client(), (*tool)->clock(), *request, settings_.hub);
}

std::optional<KnownMoves::Placed> LiveClient::find_object(std::int32_t object, std::optional<double> scene_time_s) {
  const std::scoped_lock lock(mutex_);
  if (!newest_) return std::nullopt;
  return known_moves_.find(object, scene_time_s.value_or(1e-9 * static_cast<double>(newest_->scene_time_ns)));
}

KnownMoves::Named LiveClient::find_named(std::string_view name) {
  const std::scoped_lock lock(mutex_);
  return known_moves_.find_named(name);
}

std::string LiveClient::find_name(std::int32_t object) {
  const std::scoped_lock lock(mutex_);
  return std::string(known_moves_.find_name(object));
}

std::vector<std::int32_t> LiveClient::movable_objects() {
  const std::scoped_lock lock(mutex_);
  return known_moves_.objects();
}

LiveClient::CarvesSoFar LiveClient::find_carves(std::uint32_t after) {
  const std::scoped_lock lock(mutex_);
  CarvesSoFar so_far{.newest = known_carves_.newest()};
  const std::size_t end = std::min<std::size_t>(known_carves_.complete(), carves_.size());
  for (std::size_t n = after; n < end; ++n) so_far.carves.push_back(carves_[n]);
  return so_far;
}

void LiveClient::take_move(const Message& message, Arrival arrival) {
  const auto* move = std::get_if<ObjectMove>(&message);
  if (move == nullptr) return;
  const std::scoped_lock lock(mutex_);
  known_moves_.take(*move, arrival);
}

// The carves of an earlier haptics process are void: with a new process, the objects are whole again.
void LiveClient::take_carves(const Message& message, Arrival arrival) {
  const auto* carves = std::get_if<Carves>(&message);
  if (carves == nullptr) return;
  const std::scoped_lock lock(mutex_);
  const KnownCarves::News news = known_carves_.take(*carves, arrival);
  if (news.starts_anew) carves_.clear();
  const std::size_t end = std::size_t{carves->first} + carves->count - 1;  // serial of the last carve; the new ones come last
  if (news.carves.empty() || end > kMaxCarves) return;
  if (carves_.size() < end) carves_.resize(end);
  std::copy(news.carves.begin(), news.carves.end(), carves_.begin() + static_cast<std::ptrdiff_t>(end - news.carves.size()));
}

void LiveClient::take_view(const Message& message, Arrival arrival) {
  const std::scoped_lock lock(mutex_);
  others_view_.take(message, arrival, view_);
}

void LiveClient::request_carves(HubClient& client, std::int64_t now_ns) {
  const std::scoped_lock lock(mutex_);
  if (const auto request = known_carves_.take_request(now_ns)) client.send(*request);
}

void LiveClient::run() {
  HubClient& client = connection_->client();
  const Clock& clock = connection_->clock();
  Datagram datagram;
  std::uint64_t joins = 0;
  while (!is_stopping_.load(std::memory_order_relaxed)) {
    const bool has_datagram = client.receive(datagram, clock.now_ns() + kClientTurnNs);
    if (std::exchange(joins, client.counts().joins) != client.counts().joins) {
      const std::scoped_lock lock(mutex_);
      others_view_.forget();
    }
    is_joined_.store(client.state() == JoinState::joined, std::memory_order_relaxed);
    send_view(clock.now_ns());
    markers_.send(client, clock.now_ns());
    moves_.send(client, clock.now_ns());
    shapes_.send(client, clock.now_ns());
    request_carves(client, clock.now_ns());
    if (!has_datagram) continue;
    markers_.take(datagram.message);
    moves_.take(datagram.message);
    take_shape_reply(datagram.message);
    take_move(datagram.message, client.last_arrival());
    take_carves(datagram.message, client.last_arrival());
    take_view(datagram.message, client.last_arrival());
    const auto* probe = std::get_if<ProbeState>(&datagram.message);
    if (probe == nullptr || client.last_arrival() == Arrival::reordered) continue;
    {
      const std::scoped_lock lock(mutex_);
      newest_ = *probe;
    }
    client.send(FrameAck{.echo_sample = probe->sample, .echo_sample_time_ns = probe->sample_time_ns});
  }
}

void LiveClient::send_view(std::int64_t now_ns) noexcept {
  const std::scoped_lock lock(mutex_);
  // If another node has turned the scene since, our view is obsolete and no longer sent.
  const std::uint32_t newest_in_use = std::max(others_view_.revision(), newest_ ? newest_->view_revision : 0U);
  if (view_.revision == 0 || now_ns < next_view_ns_ || newest_in_use >= view_.revision) return;
  next_view_ns_ = now_ns + kViewEveryNs;
  connection_->client().send(view_);
}

}  // namespace hapton::python
