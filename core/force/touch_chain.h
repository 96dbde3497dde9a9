#pragma once

#include <optional>
#include <utility>

#include "core/force/force_method.h"
#include "core/math/types.h"

namespace hapton {

// One step through links that each feel a part of a scene in a frame of its own: what stands still, and each motion. Each link follows the
// proxy of the one before instead of the device:
//
//   device -> what stands still -> first motion -> ... -> last motion -> what stands still = proxy of all
//
// The last one is a second link for what stands still, without friction and damping: it takes part while something that moves pushes, so
// that this never pushes the proxy into what stands still. The force is the sum of theirs.
//
// MovingMethod and PatchChain (patch/patch_chain.h) are such chains, and so give the same forces. Frame: S. RT: all. Threads: one.
class TouchChain {
 public:
  // The next step begins there: `begin` is called with each link.
  void reset(const Vec3& p_S) noexcept { start_ = p_S; }
  // The proxy is known to be there, and the links are: nothing pushes yet.
  void go_on_from(const Vec3& p_S) noexcept {
    last_p_S_ = p_S;
    start_.reset();
    is_pushed_ = false;
  }

  // A Link has is_second, and moves(). begin(link, p_S): it starts there. resume(link, p_S): the second one goes on from exactly there.
  // feel(link, p_S): its step, with the device there; the result in S, with the scene's number of the object. All noexcept.
  template <class Links, class Begin, class Resume, class Feel>
  MethodOutput step(Links& links, const Vec3& p_SD, Begin&& begin, Resume&& resume, Feel&& feel) noexcept {
    MethodOutput output{.force_n = Vec3::Zero(), .p_SP = p_SD};
    const bool begins = start_.has_value();
    const Vec3 last = start_.value_or(last_p_S_.value_or(p_SD));
    const bool was_pushed = std::exchange(is_pushed_, false) && !begins;
    double most_n = 0.0;
    for (auto& link : links) {
      if (link.is_second && !is_pushed_) continue;
      // It was where the proxy was, which all others have left outside of what stands still.
      if (link.is_second && !was_pushed) resume(link, last);
      if (!link.is_second && begins) begin(link, last);
      const MethodOutput felt = feel(link, output.p_SP);
      if (!felt.contact) continue;
      output.contact = true;
      output.force_n += felt.force_n;
      output.p_SP = felt.p_SP;
      if (const double pushes = felt.force_n.norm(); felt.object >= 0 && pushes >= most_n) {
        most_n = pushes;
        output.object = felt.object;
      }
      is_pushed_ = is_pushed_ || (!link.is_second && link.moves());
    }
    start_.reset();
    last_p_S_ = output.p_SP;
    return output;
  }

 private:
  bool is_pushed_ = false;        // something that moves was in contact in the last step
  std::optional<Vec3> last_p_S_;  // the proxy of the last step
  std::optional<Vec3> start_;     // reset() was called: where the next step begins
};

}  // namespace hapton
