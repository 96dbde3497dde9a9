#include "link/hub_connection.h"

#include <algorithm>

#include "link/link_key.h"
#include "link/udp_endpoint.h"

namespace hapton {
namespace {

constexpr std::int64_t kJoinCheckPeriodNs = 20 * kNanosecondsPerMillisecond;  // between two checks of the state
// Longer than the hub keeps the place of a haptics node that has just died (HubPeers::kHapticsTimeoutNs).
constexpr std::int64_t kRejectedNs = 200 * kNanosecondsPerMillisecond;

KeyRole key_role_of(NodeRole role) {
  switch (role) {
    case NodeRole::haptics:
      return KeyRole::haptics;
    case NodeRole::vision:
      return KeyRole::vision;
    case NodeRole::io:
    case NodeRole::tool:
      break;
  }
  return KeyRole::tool;
}

}  // namespace

HubConnection::~HubConnection() = default;

Result<std::unique_ptr<HubConnection>> HubConnection::open(NodeRole role, const Settings& settings) {
  const auto hub = parse_address(settings.hub);
  if (!hub) return tl::unexpected(hub.error());
  const auto key = find_role_key(settings.key_file, *hub, key_role_of(role));
  if (!key) return tl::unexpected(key.error());
  auto endpoint = open_udp_endpoint(any_address_like(*hub));
  if (!endpoint) return tl::unexpected(endpoint.error());
  std::unique_ptr<HubConnection> connection(new HubConnection(*hub, role));
  connection->endpoint_ = std::move(*endpoint);
  SealedClient::Options sealing;
  if (settings.has_worker) sealing.worker = AgreementWorker::Where::own_thread;
  connection->sealed_ = std::make_unique<SealedClient>(*connection->endpoint_, connection->clock_, *key, *hub, sealing);
  connection->client_ = std::make_unique<HubClient>(*connection->sealed_, connection->clock_, role, *hub);
  return connection;
}

Result<void> HubConnection::wait_until_joined(double seconds) {
  const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  Datagram ignored;
  std::int64_t rejected_ns = end_ns;
  while (client_->state() != JoinState::joined && clock_.now_ns() < std::min(end_ns, rejected_ns)) {
    client_->receive(ignored, clock_.now_ns() + kJoinCheckPeriodNs);
    if (client_->state() != JoinState::rejected) rejected_ns = end_ns;
    if (client_->state() == JoinState::rejected && rejected_ns == end_ns) rejected_ns = clock_.now_ns() + kRejectedNs;
  }
  if (client_->state() == JoinState::joined) return {};
  if (client_->state() == JoinState::rejected) {
    if (role_ != NodeRole::haptics)
      return fail("the hub at {} has no room for another program; stop one of those that joined it", to_string(hub_));
    return fail("the hub at {} has a haptics node already; stop that one first", to_string(hub_));
  }
  return fail("no reply from a hub at {}; start io_node there, give another address, or give the hub's key", to_string(hub_));
}

}  // namespace hapton
