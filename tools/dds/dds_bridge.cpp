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

// Above ordinary programs, so that a sample is published before the next one comes, and below all nodes (80), which must never be delayed.
constexpr int kPublisherPriority = 10;
constexpr double kBridgeJoinTimeoutS = 5.0;  // how long to wait for the hub; a free choice
// The longest wait for a datagram, and so the longest time until a stop is noticed; a free choice.
constexpr std::int64_t kBridgeMaxWaitNs = 20 * kNanosecondsPerMillisecond;
// The time after which the measured rate of the hub is reliable.
constexpr std::int64_t kRateSettleNs = 3 * kNanosecondsPerSecond;
constexpr double kMaxSkippedShare = 0.1;                          // share of the samples; advice is given above it; a free choice
constexpr std::int64_t kWarnEveryNs = 5 * kNanosecondsPerSecond;  // a free choice

// The time of day minus the time of the clock. Both are read again if this thread was held up between the two readings.
std::int64_t day_offset_ns(const Clock& clock) {
  constexpr std::int64_t kMaxReadingGapNs = 10'000;  // if two readings of the clock are no farther apart, the thread was not held up
  std::int64_t offset_ns = 0;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 3 && least_ns > kMaxReadingGapNs; ++i) {
    const std::int64_t before_ns = clock.now_ns();
    const auto day = std::chrono::system_clock::now().time_since_epoch();
    const std::int64_t took_ns = clock.now_ns() - before_ns;
    if (took_ns >= least_ns) continue;
    least_ns = took_ns;
    offset_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(day).count() - before_ns - took_ns / 2;
  }
  return offset_ns;
}

// The line that warns of this verdict.
std::string warning_of(ServoForce::Verdict verdict, const BridgeSettings& settings) {
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

// Returns null if forces are not accepted.
Result<std::unique_ptr<ForceReplier>> start_replier(const BridgeSettings& settings, RosNode& node) {
  if (!settings.accept_forces_n) return std::unique_ptr<ForceReplier>();
  HubConnection::Settings hub = settings.hub;
  if (!settings.haptics_key_file.empty()) hub.key_file = settings.haptics_key_file;
  hub.has_worker = true;
  return ForceReplier::start(node, {.hub = hub,
                                    .most_n = *settings.accept_forces_n,
                                    .most_nm = settings.accept_torques_nm,
                                    .frame = settings.ros.frame,
                                    .realtime = settings.realtime});
}

std::string describe_topics(const BridgeSettings& settings) {
  const std::string& prefix = settings.ros.prefix;
  std::string text = fmt::format("publishing {}/measured_cf and more in DDS domain {}", prefix, settings.ros.domain);
  if (!settings.accept_forces_n) return text;
  text += fmt::format("; forces of up to {} N", *settings.accept_forces_n);
  if (settings.accept_torques_nm > 0.0) text += fmt::format(" and torques of up to {} Nm", settings.accept_torques_nm);
  return text + fmt::format(" are taken from {}/servo_cf", prefix);
}

// Gives advice once, if the hub sends so many samples that some are skipped. An empty text means no advice.
class RateAdvice {
 public:
  explicit RateAdvice(std::int64_t start_ns) : due_ns_(start_ns + kRateSettleNs) {}

  std::string make_if_due(std::uint64_t samples, std::uint64_t skipped, double servo_rate_hz, std::int64_t now_ns) {
    if (is_done_ || now_ns < due_ns_) return {};
    is_done_ = true;
    const double total = static_cast<double>(samples + skipped);
    if (static_cast<double>(skipped) < kMaxSkippedShare * total) return {};
    return fmt::format("{:.0f} of {:.0f} samples a second arrive; with io_node --vision-rate {:.0f}, as many as this host can handle",
                       static_cast<double>(samples) / total * servo_rate_hz, servo_rate_hz, std::min(2.0 * servo_rate_hz, kMaxServoRateHz));
  }

 private:
  std::int64_t due_ns_;
  bool is_done_ = false;
};

// Says what was dropped or scaled down, at most once per kWarnEveryNs.
class ForceWarnings {
 public:
  std::string make_if_due(ForceReplier* replier, const BridgeSettings& settings, std::int64_t now_ns) {
    if (replier == nullptr || now_ns < next_ns_) return {};
    const auto warning = replier->take_warning();
    if (!warning) return {};
    next_ns_ = now_ns + kWarnEveryNs;
    return warning_of(*warning, settings);
  }

 private:
  std::int64_t next_ns_ = 0;
};

}  // namespace

std::optional<RosSample> SampleMaker::make(const ProbeState& probe, std::uint64_t session, std::int64_t received_ns,
                                           std::int64_t day_offset) noexcept {
  if (session != session_) {
    session_ = session;
    stamp_clock_.reset();
    linear_velocity_.reset();
    angular_velocity_.reset();
    last_probe_ = {};
  }
  const bool is_first = last_probe_.sample == 0;
  if (!is_first && (probe.sample <= last_probe_.sample || probe.sample_time_ns <= last_probe_.sample_time_ns)) return std::nullopt;
  const double dt_s = is_first ? 1.0 : 1e-9 * static_cast<double>(probe.sample_time_ns - last_probe_.sample_time_ns);
  if (!is_first) {
    skipped_ += probe.sample - last_probe_.sample - 1;
    rotation_sum_rad_ += turn_between(last_probe_.q_WT, probe.q_WT);
  }
  linear_velocity_.add(probe.p_WD, dt_s);
  angular_velocity_.add(rotation_sum_rad_, dt_s);
  last_probe_ = probe;
  return RosSample{.probe = probe,
                   .linear_m_per_s = linear_velocity_.mean(),
                   .angular_rad_per_s = angular_velocity_.mean(),
                   .stamp_ns = stamp_clock_.stamp_ns(probe.sample_time_ns, received_ns, day_offset)};
}

Result<BridgeSummary> run_bridge(const BridgeSettings& settings, const std::function<bool()>& is_over,
                                 const std::function<void(const std::string&)>& print_line) {
  const auto address = parse_address(settings.hub.hub);
  if (!address) return tl::unexpected(address.error());
  RosNode::Options ros = settings.ros;
  ros.takes_forces = settings.accept_forces_n.has_value();
  // DDS is opened first, so that its errors are reported without a hub, too.
  const auto node = RosNode::open(ros);
  if (!node) return tl::unexpected(node.error());
  const auto connection = HubConnection::open(NodeRole::vision, settings.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kBridgeJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  const auto replier = start_replier(settings, **node);
  if (!replier) return tl::unexpected(replier.error());
  print_line(describe_topics(settings));

  const auto rights = enter_realtime({.mode = settings.realtime, .priority = kPublisherPriority, .lock_memory = false});
  if (!rights) return tl::unexpected(rights.error());
  const RealtimeReport& realtime = *replier != nullptr ? (*replier)->realtime() : *rights;  // the thread of the forces requests more rights
  if (!realtime.complete()) print_line(realtime.to_text());
  HubClient& client = (*connection)->client();
  const Clock& clock = (*connection)->clock();
  const std::int64_t start_ns = clock.now_ns();
  const std::int64_t end_ns =
      settings.seconds > 0.0 ? start_ns + static_cast<std::int64_t>(1e9 * settings.seconds) : std::numeric_limits<std::int64_t>::max();
  SampleMaker maker(is_loopback(*address));
  RateAdvice advice(start_ns);
  ForceWarnings warnings;
  const auto print_if_any = [&](const std::string& text) {
    if (!text.empty()) print_line(text);
  };
  BridgeSummary summary;
  Datagram datagram;
  while (clock.now_ns() < end_ns && !is_over()) {
    const bool has_datagram = client.receive(datagram, clock.now_ns() + kBridgeMaxWaitNs);
    const std::int64_t now_ns = clock.now_ns();
    print_if_any(warnings.make_if_due(replier->get(), settings, now_ns));
    const auto* probe = has_datagram ? std::get_if<ProbeState>(&datagram.message) : nullptr;
    if (probe == nullptr || client.last_arrival() == Arrival::reordered) continue;
    // Sent before anything else, since it asks for the next state.
    client.send(FrameAck{.echo_sample = probe->sample, .echo_sample_time_ns = probe->sample_time_ns, .every_sample = true});
    const auto sample = maker.make(*probe, client.session(), client.receive_time_ns(), day_offset_ns(clock));
    if (!sample) continue;
    (*node)->publish(*sample);
    ++summary.samples;
    print_if_any(advice.make_if_due(summary.samples, maker.skipped(), client.servo_rate_hz(), now_ns));
  }
  if (*replier) {
    (*replier)->stop();
    summary.forces = (*replier)->counts();
    summary.replies = (*replier)->replies();
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
