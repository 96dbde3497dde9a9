#include "tools/dds/dds_bridge.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "core/math/rotation_vector.h"
#include "link/address.h"
#include "tools/dds/force_replier.h"

namespace hapton::dds {
namespace {

// Above ordinary programs, so that a sample is published before the next one comes, and below all nodes (80), which it must never hold up.
constexpr int kPublisherPriority = 10;
constexpr double kBridgePatienceS = 5.0;
constexpr std::int64_t kBridgeTurnNs = 20 * kNanosecondsPerMillisecond;
// The time after which the measured rate of the hub is reliable.
constexpr std::int64_t kRateKnownNs = 3 * kNanosecondsPerSecond;
constexpr double kMostSkipped = 0.1;
constexpr std::int64_t kWarnEveryNs = 5 * kNanosecondsPerSecond;

// The time of day minus the clock's. Again, if this thread was held up between the two.
std::int64_t day_offset_ns(const Clock& clock) {
  constexpr std::int64_t kAtOnceNs = 10'000;  // two readings of the clock no farther apart: the thread was not held up
  std::int64_t offset_ns = 0;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 3 && least_ns > kAtOnceNs; ++i) {
    const std::int64_t before_ns = clock.now_ns();
    const auto day = std::chrono::system_clock::now().time_since_epoch();
    const std::int64_t took_ns = clock.now_ns() - before_ns;
    if (took_ns >= least_ns) continue;
    least_ns = took_ns;
    offset_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(day).count() - before_ns - took_ns / 2;
  }
  return offset_ns;
}

std::string why_dropped(ServoForce::Verdict verdict, const BridgeSettings& settings) {
  switch (verdict) {
    case ServoForce::Verdict::reduced:
      return fmt::format(
          "servo_cf: forces above {} N are scaled down (--accept-forces){}", *settings.accept_forces_n,
          settings.accept_torques_nm > 0.0 ? fmt::format(", and torques above {} Nm (--accept-torques)", settings.accept_torques_nm) : "");
    case ServoForce::Verdict::wrong_frame:
      return fmt::format("servo_cf: dropped a force whose frame_id is not {}", settings.ros.frame);
    case ServoForce::Verdict::not_finite:
      return "servo_cf: dropped a force that is not finite, and released the force";
    case ServoForce::Verdict::has_torque:
      return "servo_cf: dropped a wrench with a torque, and released the force; send zero, or allow torques with --accept-torques";
    case ServoForce::Verdict::other_writer:
      return "servo_cf: two publishers at a time; only the first one's forces count";
    case ServoForce::Verdict::accepted:
      break;
  }
  return {};
}

}  // namespace

std::optional<RosSample> SampleMaker::make(const ProbeState& probe, std::uint64_t session, std::int64_t received_ns,
                                           std::int64_t day_offset) noexcept {
  if (session != session_) {
    session_ = session;
    stamps_.reset();
    linear_.reset();
    angular_.reset();
    last_ = {};
  }
  const bool is_first = last_.sample == 0;
  if (!is_first && (probe.sample <= last_.sample || probe.sample_time_ns <= last_.sample_time_ns)) return std::nullopt;
  const double dt_s = is_first ? 1.0 : 1e-9 * static_cast<double>(probe.sample_time_ns - last_.sample_time_ns);
  if (!is_first) {
    skipped_ += probe.sample - last_.sample - 1;
    turned_rad_ += turn_between(last_.q_WT, probe.q_WT);
  }
  linear_.add(probe.p_WD, dt_s);
  angular_.add(turned_rad_, dt_s);
  last_ = probe;
  return RosSample{.probe = probe,
                   .linear_m_per_s = linear_.mean(),
                   .angular_rad_per_s = angular_.mean(),
                   .stamp_ns = stamps_.stamp_ns(probe.sample_time_ns, received_ns, day_offset)};
}

Result<BridgeSummary> run_bridge(const BridgeSettings& settings, const std::function<bool()>& is_over,
                                 const std::function<void(const std::string&)>& say) {
  const auto address = parse_address(settings.hub.hub);
  if (!address) return tl::unexpected(address.error());
  RosNode::Options ros = settings.ros;
  ros.takes_forces = settings.accept_forces_n.has_value();
  // DDS first: what is wrong with it shows without a hub, too.
  const auto node = RosNode::open(ros);
  if (!node) return tl::unexpected(node.error());
  const auto connection = HubConnection::open(NodeRole::vision, settings.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kBridgePatienceS); !joined) return tl::unexpected(joined.error());
  std::unique_ptr<ForceReplier> replier;
  if (ros.takes_forces) {
    HubConnection::Settings hub = settings.hub;
    if (!settings.haptics_key_file.empty()) hub.key_file = settings.haptics_key_file;
    hub.has_worker = true;
    auto started = ForceReplier::start(**node, {.hub = hub,
                                                .most_n = *settings.accept_forces_n,
                                                .most_nm = settings.accept_torques_nm,
                                                .frame = ros.frame,
                                                .realtime = settings.realtime});
    if (!started) return tl::unexpected(started.error());
    replier = std::move(*started);
  }
  say(fmt::format(
      "publishing {0}/measured_cf and more in DDS domain {1}{2}", ros.prefix, ros.domain,
      ros.takes_forces
          ? fmt::format("; forces of up to {} N{} are taken from {}/servo_cf", *settings.accept_forces_n,
                        settings.accept_torques_nm > 0.0 ? fmt::format(" and torques of up to {} Nm", settings.accept_torques_nm) : "",
                        ros.prefix)
          : ""));

  const auto rights = enter_realtime({.mode = settings.realtime, .priority = kPublisherPriority, .lock_memory = false});
  if (!rights) return tl::unexpected(rights.error());
  HubClient& client = (*connection)->client();
  const Clock& clock = (*connection)->clock();
  const std::int64_t start_ns = clock.now_ns();
  const std::int64_t end_ns =
      settings.seconds > 0.0 ? start_ns + static_cast<std::int64_t>(1e9 * settings.seconds) : std::numeric_limits<std::int64_t>::max();
  SampleMaker maker(is_loopback(*address));
  BridgeSummary summary;
  bool is_rate_told = false;
  std::int64_t next_warning_ns = 0;
  Datagram datagram;
  while (clock.now_ns() < end_ns && !is_over()) {
    const bool has_datagram = client.receive(datagram, clock.now_ns() + kBridgeTurnNs);
    const std::int64_t now_ns = clock.now_ns();
    if (replier && now_ns >= next_warning_ns) {
      if (const auto warning = replier->take_warning()) {
        say(why_dropped(*warning, settings));
        next_warning_ns = now_ns + kWarnEveryNs;
      }
    }
    const auto* probe = has_datagram ? std::get_if<ProbeState>(&datagram.message) : nullptr;
    if (probe == nullptr || client.last_arrival() == Arrival::reordered) continue;
    // First: it asks for the next state.
    client.send(FrameAck{.echo_sample = probe->sample, .echo_sample_time_ns = probe->sample_time_ns, .every_sample = true});
    const auto sample = maker.make(*probe, client.session(), client.receive_time_ns(), day_offset_ns(clock));
    if (!sample) continue;
    (*node)->publish(*sample);
    ++summary.samples;
    if (is_rate_told || now_ns - start_ns < kRateKnownNs) continue;
    is_rate_told = true;
    const double all = static_cast<double>(summary.samples + maker.skipped());
    if (static_cast<double>(maker.skipped()) < kMostSkipped * all) continue;
    say(fmt::format("{:.0f} of {:.0f} samples a second arrive; with io_node --vision-rate {:.0f}, as many as this host can handle",
                    static_cast<double>(summary.samples) / all * client.servo_rate_hz(), client.servo_rate_hz(),
                    std::min(2.0 * client.servo_rate_hz(), kMaxServoRateHz)));
  }
  if (replier) {
    replier->stop();
    summary.forces = replier->counts();
    summary.replies = replier->replies();
  }
  summary.skipped = maker.skipped();
  summary.lost = client.sequence_counts().lost;
  summary.published = (*node)->counts();
  summary.seconds = 1e-9 * static_cast<double>(clock.now_ns() - start_ns);
  summary.servo_rate_hz = client.servo_rate_hz();
  return summary;
}

std::string to_text(const BridgeSummary& summary) {
  std::string text =
      fmt::format("{} samples in {:.1f} s ({:.0f} a second), {} skipped, {} datagrams lost; {} messages published, {} failed",
                  summary.samples, summary.seconds, summary.seconds > 0.0 ? static_cast<double>(summary.samples) / summary.seconds : 0.0,
                  summary.skipped, summary.lost, summary.published.written, summary.published.failed);
  if (summary.forces) {
    const auto& forces = *summary.forces;
    text += fmt::format("; {} forces taken, {} reduced, {} dropped", forces.accepted, forces.reduced,
                        forces.wrong_frame + forces.not_finite + forces.has_torque + forces.other_writer);
  }
  return text;
}

}  // namespace hapton::dds
