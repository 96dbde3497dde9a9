// Any bytes as a state of the Haply Inverse Service.
#include <cmath>

#include "devices/haply_messages.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(haply) {
  using namespace hapton;
  (void)haply::read_version({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const auto state = haply::read_state({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!state) {
    fuzz::require(!state.error().what.empty());
    return;
  }
  for (const haply::Arm& arm : state->arms) {
    fuzz::require(!arm.id.empty() && arm.position_m.allFinite());
    haply::Session session;
    session.update(arm);
    if (!session.is_scaled()) fuzz::require(session.force_from_w(Vec3::UnitX()).allFinite());
    // Its id is sent back to the service, and cannot break the syntax of that message.
    fuzz::require(haply::read_state(haply::force_message(arm.id, Vec3::Zero())).has_value());
  }
  if (state->grip) fuzz::require(std::abs(state->grip->q_WT.norm() - 1.0) < 1e-9);
}
