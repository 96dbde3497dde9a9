#pragma once

#include <memory>

#include "remote/sample_link.h"

namespace hapton {

// One plane: the haptics node sends where the surface was below a sample, and its stiffness; beside the device the newest plane is the
// surface. It is one-sided, and without contact at the sample there is none. Its numbers are those of a ForceCommand: the visual offset
// leads to the plane, along its normal. Source: Mark, Randolph, Finch, Van Verth and Taylor, "Adding force feedback to graphics systems"
// (1996); their recovery time, which eases the change from plane to plane, is left out.
class RemotePlane final : public RemoteTouch {
 public:
  RemotePlane(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network) : link_(std::move(method), network) {}

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override;
  RemoteTraffic traffic() const override { return link_.traffic(); }

 private:
  SampleLink link_;
  Vec3 p_WQ_ = Vec3::Zero();       // on the plane
  Vec3 outward_W_ = Vec3::Zero();  // unit; zero: no contact
  double stiffness_n_per_m_ = 0.0;
};

}  // namespace hapton
