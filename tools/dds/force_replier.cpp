#include "tools/dds/force_replier.h"

#include <algorithm>

#include "runtime/start_thread.h"

namespace hapton::dds {
namespace {

constexpr double kReplierJoinTimeoutS = 5.0;  // how long to wait for the hub; a free choice
// The longest wait for a datagram, and so the longest time until a stop is noticed; a free choice
constexpr std::int64_t kReplierMaxWaitNs = 20 * kNanosecondsPerMillisecond;

}  // namespace

Result<std::unique_ptr<ForceReplier>> ForceReplier::start(RosNode& node, const Settings& settings) {
  auto connection = HubConnection::open(NodeRole::haptics, settings.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kReplierJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  std::unique_ptr<ForceReplier> replier(new ForceReplier(node, settings, std::move(*connection)));
  auto rights = replier->rights_.get_future().get();
  if (!rights) return tl::unexpected(rights.error());
  replier->realtime_ = std::move(*rights);
  return replier;
}

ForceReplier::ForceReplier(RosNode& node, const Settings& settings, std::unique_ptr<HubConnection> connection)
    : node_(node), connection_(std::move(connection)), force_(settings.frame, settings.most_n, settings.most_nm) {
  thread_ = start_thread([this, realtime = settings.realtime] { run(realtime); });
}

ForceReplier::~ForceReplier() { stop(); }

void ForceReplier::stop() {
  is_stopping_.store(true);
  if (thread_.joinable()) thread_.join();
  connection_.reset();  // sends a Bye, so that the hub releases the force at once
}

std::optional<ServoForce::Verdict> ForceReplier::take_warning() noexcept {
  const int warning = warning_.exchange(-1);
  if (warning < 0) return std::nullopt;
  return static_cast<ServoForce::Verdict>(warning);
}

void ForceReplier::take_commands() {
  node_.take_forces([this](const ServoCommand& command) {
    const ServoForce::Verdict verdict = force_.take(command, connection_->clock().now_ns());
    if (verdict != ServoForce::Verdict::accepted) warning_.store(static_cast<int>(verdict));
  });
}

void ForceReplier::run(RealtimeMode realtime) {
  auto rights = enter_realtime({.mode = realtime});
  const bool has_begun = rights.has_value();
  rights_.set_value(std::move(rights));
  if (!has_begun) return;
  HubClient& client = connection_->client();
  const Clock& clock = connection_->clock();
  Datagram datagram;
  while (!is_stopping_.load(std::memory_order_relaxed)) {
    if (!client.receive(datagram, clock.now_ns() + kReplierMaxWaitNs)) {
      take_commands();  // so that no command waits while there is no hub and then counts as new
      continue;
    }
    std::optional<DeviceState> newest;
    std::uint32_t states = 0;
    do {
      const auto* state = std::get_if<DeviceState>(&datagram.message);
      if (state == nullptr || client.last_arrival() == Arrival::reordered) continue;
      newest = *state;
      ++states;
    } while (client.receive(datagram, 0));
    if (newest) reply(*newest, states);
  }
}

void ForceReplier::reply(const DeviceState& state, std::uint32_t states) {
  take_commands();
  HubClient& client = connection_->client();
  const std::int64_t now_ns = connection_->clock().now_ns();
  command_.force_n = force_.force_n(now_ns);
  command_.torque_nm = force_.torque_nm(now_ns);
  // Bit i of replied_before is for the sample i + 1 before this one: the bits shift by the samples since the last reply, whose bit is set.
  const std::uint64_t samples_since_reply = state.sample - command_.echo_sample;
  command_.replied_before = replies_ == 0 || samples_since_reply - 1 >= 63
                                ? 0
                                : command_.replied_before << samples_since_reply | std::uint64_t{1} << (samples_since_reply - 1);
  command_.echo_sample = state.sample;
  command_.echo_sample_time_ns = state.sample_time_ns;
  command_.skipped_samples = states - 1;
  command_.compute_ns = static_cast<std::uint32_t>(std::max<std::int64_t>(0, now_ns - client.receive_time_ns()));
  client.send(command_);
  ++replies_;
}

}  // namespace hapton::dds
