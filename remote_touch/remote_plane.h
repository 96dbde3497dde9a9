#pragma once

#include <memory>

#include "remote_touch/sample_link.h"

namespace hapton {

// The haptics node sends the plane of the surface below each sample, and its stiffness; beside the device the newest plane acts as the
// surface. The plane is one-sided, and there is none if the sample had no contact. It is described by a ForceCommand: the visual offset
// leads from the device to the plane, along its normal. Source: Mark, Randolph, Finch, Van Verth and Taylor, "Adding force feedback to
// graphics systems" (1996); we leave out their recovery time, which smooths the change from plane to plane.
class RemotePlane final : public RemoteTouch {
 public:
  RemotePlane(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network) : link_(std::move(method), network) {}

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override;
  RemoteTraffic traffic() const override { return link_.traffic(); }

 private:
  SampleLink link_;
  Vec3 p_WQ_ = Vec3::Zero();       // a point on the plane
  Vec3 outward_W_ = Vec3::Zero();  // unit; zero: no contact
  double stiffness_n_per_m_ = 0.0;
};

}  // namespace hapton
