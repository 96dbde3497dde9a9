#include "remote_touch/remote_deadband.h"

#include <utility>

#include "remote_touch/packet_size.h"
#include "remote_touch/sample_link.h"

namespace hapton {

RemoteDeadband::RemoteDeadband(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network, const Options& options)
    : options_(options),
      up_(network.up, network.seed),
      down_(network.down, back_seed(network.seed)),
      state_bytes_(packet_bytes_of_state()),
      force_bytes_(packet_bytes_of_force()),
      velocity_(options.fraction, kMinSpeed, Prediction::hold),
      step_(std::move(method)),
      force_coder_(options.fraction, kMinForceN, options.prediction) {}

RemoteStep RemoteDeadband::step(const Vec3& p_WD, std::int64_t now_ns) {
  send_motion(p_WD, now_ns);
  while (const auto motion = up_.receive(now_ns)) {
    if (seen_ && motion->sent_ns <= seen_->sent_ns) continue;
    seen_ = *motion;
    seen_at_ns_ = now_ns;
  }
  if (seen_) run_haptics(now_ns);
  while (const auto force = down_.receive(now_ns)) {
    if (force->sent_ns <= force_sent_ns_) continue;
    force_sent_ns_ = force->sent_ns;
    force_.update(force->force_n, now_ns);
  }
  return {force_.predict(now_ns).value_or(Vec3::Zero()), now_ns};
}

Vec3 RemoteDeadband::measure_velocity(const Vec3& p_WD, std::int64_t now_ns) {
  if (recent_.size() < kVelocityRows) recent_.emplace_back(now_ns, p_WD);
  const std::size_t at = samples_++ % kVelocityRows;
  const auto [before_ns, before] = samples_ <= kVelocityRows ? recent_.front() : recent_[at];
  recent_[at] = {now_ns, p_WD};
  if (now_ns <= before_ns) return Vec3::Zero();
  return (p_WD - before) / (1e-9 * static_cast<double>(now_ns - before_ns));
}

void RemoteDeadband::send_motion(const Vec3& p_WD, std::int64_t now_ns) {
  const Vec3 v_WD = measure_velocity(p_WD, now_ns);
  bool is_off = true;
  if (told_) {
    const Vec3 taken = told_->p_WD + 1e-9 * static_cast<double>(now_ns - told_->sent_ns) * told_->v_WD;
    is_off = (p_WD - taken).norm() >= options_.fraction * kPositionM;
  }
  if (!velocity_.note(v_WD, now_ns) && !is_off) return;
  (void)velocity_.send();
  told_ = Motion{now_ns, p_WD, v_WD};
  up_.send(*told_, state_bytes_, now_ns);
}

void RemoteDeadband::run_haptics(std::int64_t now_ns) {
  TouchInput input;
  input.p_WD = seen_->p_WD + 1e-9 * static_cast<double>(now_ns - seen_at_ns_) * seen_->v_WD;
  if (stepped_ns_ < 0) {
    step_.reset(input);
  } else {
    input.dt_s = 1e-9 * static_cast<double>(now_ns - stepped_ns_);
  }
  stepped_ns_ = now_ns;
  const TouchOutput touch = step_.step(input);
  const bool has_changed = std::exchange(had_contact_, touch.contact) != touch.contact;
  if (!force_coder_.note(touch.force_n, now_ns) && !has_changed) return;
  down_.send({now_ns, force_coder_.send()}, force_bytes_, now_ns);
}

}  // namespace hapton
