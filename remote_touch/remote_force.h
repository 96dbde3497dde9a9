#pragma once

#include <memory>
#include <utility>

#include "remote_touch/sample_link.h"

namespace hapton {

// Remote force: the newest force received is held until a newer one arrives. Only the governor, if the method has one, limits its age.
class RemoteForce final : public RemoteTouch {
 public:
  RemoteForce(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network) : link_(std::move(method), network) {}

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override {
    if (const auto reply = link_.exchange({now_ns, p_WD})) held_step_ = {reply->touch.force_n, reply->sample.time_ns};
    return held_step_;
  }
  RemoteTraffic traffic() const override { return link_.traffic(); }

 private:
  SampleLink link_;
  RemoteStep held_step_;
};

}  // namespace hapton
