#pragma once

#include <memory>
#include <utility>

#include "remote/sample_link.h"

namespace hapton {

// Remote force: the newest force that has come holds until a newer one does. Whether an old one is used is left to what stands before the
// motors.
class RemoteForce final : public RemoteTouch {
 public:
  RemoteForce(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network) : link_(std::move(method), network) {}

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override {
    if (const auto reply = link_.exchange({now_ns, p_WD})) held_ = {reply->touch.force_n, reply->sample.time_ns};
    return held_;
  }
  RemoteTraffic traffic() const override { return link_.traffic(); }

 private:
  SampleLink link_;
  RemoteStep held_;
};

}  // namespace hapton
