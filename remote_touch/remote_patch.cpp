#include "remote_touch/remote_patch.h"

#include <algorithm>
#include <utility>

#include "remote_touch/packet_size.h"

namespace hapton {
namespace {

constexpr double kFirstStepS = 1e-3;  // duration of the first step, which has no sample before it

// The size of the largest status: one that reports every tile as received.
std::size_t largest_status_bytes() {
  PatchStatus full;
  full.received.fill(0xff);
  full.epoch = full.newest_serial = 1000;
  full.is_wanted = true;
  full.round_trip_s = 1.0F;
  return packet_bytes_of(full);
}

}  // namespace

RemotePatch::RemotePatch(std::shared_ptr<ForceMethod> method, const TiledScene& tiles, const RemoteNetwork& network, const Options& options)
    : link_(std::move(method), network, kSampleNs),
      up_(network.up, network.seed + 1),
      down_(network.down, back_seed(network.seed + 1)),
      status_bytes_(largest_status_bytes()),
      source_(tiles, 0.0, 7, 1, options.source) {}

RemoteStep RemotePatch::step(const Vec3& p_WD, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (const auto reply = link_.exchange({now_ns, p_WD})) round_trip_s_ = 1e-9 * static_cast<double>(now_ns - reply->sample.time_ns);
  if (link_.received()) follow_hand(*link_.received());
  send_status(now_ns);
  run_haptics(now_ns);
  take_parts(now_ns);
  make_patches(p_WD, now_ns);
  const double dt_s = last_step_ns_ > 0 ? 1e-9 * static_cast<double>(now_ns - last_step_ns_) : kFirstStepS;
  last_step_ns_ = now_ns;
  const auto output = touch_.step({.p_WD = p_WD, .dt_s = dt_s});
  const bool had_patch_force = std::exchange(had_patch_force_, output.has_value());
  if (!output) {
    fade_.forget();
    return {Vec3::Zero(), now_ns};
  }
  if (output->is_handed_over || !had_patch_force) fade_.begin();
  fade_.begin_from(output->difference_n);
  return {fade_.step(output->force_n, output->contact, dt_s), now_ns};
}

bool RemotePatch::is_ready() const {
  const double quiet_s = 0.5 + 1.5 * std::max(round_trip_s_, 0.0);
  return part_sent_ns_ >= 0 && round_trip_s_ >= 0.0 && now_ns_ - part_sent_ns_ > static_cast<std::int64_t>(1e9 * quiet_s);
}

RemoteTraffic RemotePatch::traffic() const {
  return link_.traffic() + RemoteTraffic{.up = up_.traffic(), .down = down_.traffic(), .scene = down_.traffic()};
}

void RemotePatch::send_status(std::int64_t now_ns) {
  if (last_status_ns_ > 0 && now_ns - last_status_ns_ < (has_new_parts_ ? kSoonNs : kStatusNs)) return;
  last_status_ns_ = now_ns;
  has_new_parts_ = false;
  PatchStatus status = store_.status();
  status.is_wanted = true;
  status.round_trip_s = static_cast<float>(std::max(round_trip_s_, 0.0));
  up_.send(status, status_bytes_, now_ns);
}

void RemotePatch::follow_hand(const SampleOnTheWay& sample) {
  const double dt_s = last_sample_ns_ ? 1e-9 * static_cast<double>(sample.time_ns - *last_sample_ns_) : 0.0;
  last_sample_ns_ = sample.time_ns;
  hand_.follow(sample.p_WD, dt_s);
  source_.aim(hand_);
}

void RemotePatch::run_haptics(std::int64_t now_ns) {
  while (const auto status = up_.receive(now_ns)) {
    source_.accept(*status);
    is_requested_ = true;
  }
  if (!is_requested_ || !last_sample_ns_ || now_ns - last_send_check_ns_ < kSendNs) return;
  last_send_check_ns_ = now_ns;
  while (const auto part = source_.take(now_ns)) {
    part_sent_ns_ = now_ns;
    down_.send(*part, packet_bytes_of(*part), now_ns);
  }
}

void RemotePatch::take_parts(std::int64_t now_ns) {
  while (const auto part = down_.receive(now_ns)) {
    (void)store_.accept_part(*part);
    has_new_parts_ = true;
  }
}

// Makes one patch at a time, as the hub's patch thread does.
void RemotePatch::make_patches(const Vec3& p_WD, std::int64_t now_ns) {
  (void)touch_.take_retired();
  maker_.note_hand(touch_.hand_at(p_WD, now_ns));
  if (next_patch_ == nullptr) {
    next_patch_ = maker_.make_if_due(store_, 0);
    next_patch_ready_ns_ = now_ns + std::max(kMinMakeNs, kTriangleNs * static_cast<std::int64_t>(maker_.triangles()));
  }
  if (next_patch_ != nullptr && now_ns >= next_patch_ready_ns_) (void)touch_.offer(std::move(next_patch_));
}

}  // namespace hapton
