#include "vision_node/head_tracker.h"

#include <utility>

#include <fmt/format.h>

#include "runtime/log.h"

namespace hapton {
namespace {

// Least time between two log lines: a tracker that loses the head again and again does not fill the log.
constexpr std::int64_t kLogPauseNs = 5'000'000'000;
// A running server has replied within this time.
constexpr std::int64_t kFirstPoseTimeoutNs = 1'000'000'000;

}  // namespace

Result<HeadInput> parse_head_input(std::string_view text) {
  constexpr std::string_view kVrpn = "vrpn:";
  if (text == "keys") return HeadInput{};
  if (text == "spacemouse") return HeadInput{.is_space_mouse = true, .tracker = {}};
  if (!text.starts_with(kVrpn)) return fail("'{}' is unknown; give keys, spacemouse or vrpn:NAME@HOST[:PORT]", text);
  const auto name = vrpn::parse_tracker_name(text.substr(kVrpn.size()));
  if (!name) return tl::unexpected(name.error());
  return HeadInput{.is_space_mouse = false, .tracker = *name};
}

Head find_head(const HeadSource& source, const vrpn::TrackerPose& sensor) {
  const Pose X_RB = source.X_RT * Pose(Eigen::Translation3d(sensor.p_m) * sensor.q);
  return {X_RB * source.p_BH, Quat(X_RB.linear()).normalized()};
}

Result<std::unique_ptr<HeadTracker>> HeadTracker::open(const HeadSource& source, double ipd_m) {
  auto link = vrpn::TrackerLink::open(*source.tracker, source.sensor);
  if (!link) return tl::unexpected(link.error());
  return std::unique_ptr<HeadTracker>(new HeadTracker(source, ipd_m, std::move(*link)));
}

HeadTracker::HeadTracker(const HeadSource& source, double ipd_m, std::unique_ptr<vrpn::TrackerLink> link)
    : source_(source), ipd_m_(ipd_m), link_(std::move(link)) {}

std::optional<Head> HeadTracker::take_head(std::int64_t now_ns) {
  if (opened_ns_ < 0) opened_ns_ = now_ns;
  std::optional<Head> head;
  if (const auto sensor = link_->take_newest(now_ns)) {
    head = find_head(source_, *sensor);
    if (is_possible(*head, ipd_m_)) {
      possible_ns_ = now_ns;
    } else {
      impossible_ns_ = now_ns;
      impossible_m_ = head->p_RH;
      head.reset();
    }
  }
  report(now_ns);
  return head;
}

HeadTracker::State HeadTracker::find_state(std::int64_t now_ns) const {
  if (possible_ns_ && now_ns - *possible_ns_ < kStaleNs) return State::tracked;
  if (impossible_ns_ && now_ns - *impossible_ns_ < kStaleNs) return State::impossible;
  if (!possible_ns_ && now_ns - opened_ns_ < kFirstPoseTimeoutNs) return State::beginning;
  if (!link_->is_connected()) return State::absent;
  return possible_ns_ ? State::lost : State::silent;
}

std::string HeadTracker::describe(std::int64_t now_ns) const {
  const std::string name = fmt::format("{}@{}", source_.tracker->device, source_.tracker->host);
  switch (find_state(now_ns)) {
    case State::beginning:
    case State::tracked:
      break;
    case State::absent:
      return fmt::format("no VRPN server replies for {}; the head stays where it was", name);
    case State::silent:
      return fmt::format("{} sends no pose of sensor {} (its server has: {}); check --head and --head-sensor", name, source_.sensor,
                         link_->describe_devices());
    case State::lost:
      return fmt::format("{} has sent no pose for {} s; the head stays where it was", name, (now_ns - *possible_ns_) / 1'000'000'000);
    case State::impossible:
      return fmt::format(
          "{} reports the head at {:.4g} {:.4g} {:.4g} mm, which is not in front of the screen; check --tracker-mm and --tracker-turn-deg",
          name, 1e3 * impossible_m_.x(), 1e3 * impossible_m_.y(), 1e3 * impossible_m_.z());
  }
  return {};
}

void HeadTracker::report(std::int64_t now_ns) {
  const State now = find_state(now_ns);
  const bool is_too_soon = reported_ns_ && now_ns - *reported_ns_ < kLogPauseNs;
  if (now == reported_state_ || now == State::beginning || is_too_soon) return;
  reported_state_ = now;
  reported_ns_ = now_ns;
  if (now == State::tracked) {
    log_info("{}@{} tracks the head", source_.tracker->device, source_.tracker->host);
  } else {
    log_warning("head: {}", describe(now_ns));
  }
}

}  // namespace hapton
