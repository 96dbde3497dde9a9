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
    if (received_motion_ && motion->sent_ns <= received_motion_->sent_ns) continue;
    received_motion_ = *motion;
    received_ns_ = now_ns;
  }
  if (received_motion_) run_haptics(now_ns);
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
  bool has_drifted = true;
  if (sent_motion_) {
    const Vec3 predicted = sent_motion_->p_WD + 1e-9 * static_cast<double>(now_ns - sent_motion_->sent_ns) * sent_motion_->v_WD;
    has_drifted = (p_WD - predicted).norm() >= options_.fraction * kPositionM;
  }
  if (!velocity_.note(v_WD, now_ns) && !has_drifted) return;
  (void)velocity_.send();
  sent_motion_ = Motion{now_ns, p_WD, v_WD};
  up_.send(*sent_motion_, state_bytes_, now_ns);
}

void RemoteDeadband::run_haptics(std::int64_t now_ns) {
  TouchInput input;
  input.p_WD = received_motion_->p_WD + 1e-9 * static_cast<double>(now_ns - received_ns_) * received_motion_->v_WD;
  if (last_step_ns_ < 0) {
    step_.reset(input);
  } else {
    input.dt_s = 1e-9 * static_cast<double>(now_ns - last_step_ns_);
  }
  last_step_ns_ = now_ns;
  const TouchOutput touch = step_.step(input);
  const bool has_changed = std::exchange(had_contact_, touch.contact) != touch.contact;
  if (!force_coder_.note(touch.force_n, now_ns) && !has_changed) return;
  down_.send({now_ns, force_coder_.send()}, force_bytes_, now_ns);
}

}  // namespace hapton
