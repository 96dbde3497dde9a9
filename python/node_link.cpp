#include "python/node_link.h"

namespace hapton::python {
namespace {

constexpr double kJoinTimeoutS = 5.0;  // a free choice

// Bit i: sample `now` - 1 - i had a reply. `before`: the same mask for sample `last`, the last one with a reply.
std::uint64_t shift_replied(std::uint64_t before, std::uint64_t last, std::uint64_t now) {
  const std::uint64_t sample_step = now - last;
  if (sample_step == 0 || sample_step > 63) return 0;
  return before << sample_step | std::uint64_t{1} << (sample_step - 1);
}

}  // namespace

Result<std::unique_ptr<NodeLink>> NodeLink::open(const std::string& hub, const std::string& key_file) {
  auto connection = HubConnection::open(NodeRole::haptics, {.hub = hub, .key_file = key_file, .has_worker = true});
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  return std::unique_ptr<NodeLink>(new NodeLink(std::move(*connection)));
}

std::optional<DeviceState> NodeLink::next(std::int64_t deadline_ns) noexcept {
  HubClient& client = connection_->client();
  bool has_state = false;
  for (bool is_there = client.receive(datagram_, deadline_ns); is_there; is_there = client.receive(datagram_, 0)) {
    const auto* state = std::get_if<DeviceState>(&datagram_.message);
    if (state == nullptr) markers_->take(datagram_.message);
    if (state == nullptr || client.last_arrival() == Arrival::reordered) continue;
    skipped_ += has_state ? 1 : 0;
    state_ = *state;
    arrival_ns_ = client.receive_time_ns();
    has_state = true;
  }
  return has_state ? std::optional(state_) : std::nullopt;
}

void NodeLink::reply(const Vec3& force_n) noexcept {
  command_.force_n = force_n.allFinite() ? force_n : Vec3(Vec3::Zero());
  command_.contact = !command_.force_n.isZero(0.0);
  command_.replied_before = replies_ == 0 ? 0 : shift_replied(command_.replied_before, command_.echo_sample, state_.sample);
  command_.echo_sample = state_.sample;
  command_.echo_sample_time_ns = state_.sample_time_ns;
  command_.skipped_samples = skipped_;
  const std::int64_t compute_ns = std::max<std::int64_t>(connection_->clock().now_ns() - arrival_ns_, 0);
  command_.compute_ns = static_cast<std::uint32_t>(std::min<std::int64_t>(compute_ns, std::numeric_limits<std::uint32_t>::max()));
  connection_->client().send(command_);
  compute_times_.record(compute_ns);
  superseded_ += skipped_;
  skipped_ = 0;
  ++replies_;
}

}  // namespace hapton::python
