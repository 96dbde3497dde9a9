#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/force/touch_step.h"
#include "remote_touch/deadband_coder.h"
#include "remote_touch/remote_touch.h"

namespace hapton {

// Deadband coding both ways. The device sends position and velocity when the velocity has changed by Weber's fraction, or when the position
// that the haptics node extrapolates from the last velocity is off by that fraction of kPositionM. The haptics node computes the force at
// the device's rate, and sends it when it has changed by the fraction, or when contact begins or ends. Beside the device the last force is
// held, or continued by linear prediction.
//
// The codec assumes zero delay: neither end corrects for the transit time. Units: SI, ns. RT: no. Threads: one.
class RemoteDeadband final : public RemoteTouch {
 public:
  static constexpr double kPositionM = 1e-3;        // m: scale of the position error, see above
  static constexpr double kMinForceN = 0.1;         // a smaller force counts as this one, otherwise noise near 0 would be sent
  static constexpr double kMinSpeed = 0.05;         // m/s: a slower motion counts as this one
  static constexpr std::size_t kVelocityRows = 20;  // samples over which the velocity is a mean; otherwise encoder noise would be sent

  struct Options {
    double fraction = 0.1;
    Prediction prediction = Prediction::hold;
  };

  RemoteDeadband(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network, const Options& options);

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override;
  RemoteTraffic traffic() const override { return {up_.traffic(), down_.traffic(), {}}; }

 private:
  struct Motion {
    std::int64_t sent_ns = 0;
    Vec3 p_WD = Vec3::Zero();
    Vec3 v_WD = Vec3::Zero();
  };
  struct Force {
    std::int64_t sent_ns = 0;
    SignalUpdate force_n;
  };

  Vec3 measure_velocity(const Vec3& p_WD, std::int64_t now_ns);
  void send_motion(const Vec3& p_WD, std::int64_t now_ns);
  void run_haptics(std::int64_t now_ns);

  Options options_;
  NetworkPath<Motion> up_;
  NetworkPath<Force> down_;
  std::size_t state_bytes_;
  std::size_t force_bytes_;

  // At the device.
  std::vector<std::pair<std::int64_t, Vec3>> recent_;  // a ring
  std::size_t samples_ = 0;
  DeadbandCoder velocity_;
  std::optional<Motion> sent_motion_;  // the motion sent last
  PredictedSignal force_;
  std::int64_t force_sent_ns_ = -1;

  // The haptics node.
  TouchStep step_;
  std::optional<Motion> received_motion_;
  std::int64_t received_ns_ = 0;
  std::int64_t last_step_ns_ = -1;
  DeadbandCoder force_coder_;
  bool had_contact_ = false;
};

}  // namespace hapton
