#pragma once

#include <memory>

#include "remote_touch/haptics_end.h"
#include "remote_touch/remote_touch.h"

namespace hapton {

// Touch with the whole scene at the device: no network and no delay. All other methods are compared with this one.
class WholeScene final : public RemoteTouch {
 public:
  explicit WholeScene(std::shared_ptr<ForceMethod> method) : haptics_(std::move(method)) {}

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override {
    last_ = haptics_.reply({now_ns, p_WD})->touch;
    return {last_.force_n, now_ns};
  }
  RemoteTraffic traffic() const override { return {}; }
  const TouchOutput& last() const noexcept { return last_; }

 private:
  HapticsEnd haptics_;
  TouchOutput last_;
};

}  // namespace hapton
