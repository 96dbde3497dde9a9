#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

// What the Haply Inverse Service and its clients say to each other, version 3.5: JSON texts. Pure.
// Source: the service's public documentation (docs.haply.co/inverseSDK).
namespace hapton::haply {

// The service's axes are x right, y away from the user, z up, from the device's mounting plate; W's are x right, y up, z towards the user,
// from the middle of where the cursor is at home.
Vec3 to_w(const Vec3& p_m);
Vec3 force_from_w(const Vec3& force_n);
Quat to_w(const Quat& q);

// One Inverse3 in an inventory or a state.
struct Arm {
  std::string id;
  std::string model;     // inventories only
  std::string firmware;  // inventories only
  Vec3 p_WD = Vec3::Zero();
  bool is_calibrated = true;  // as far as it says
};

// A grip that is held by hand: orientation and buttons.
struct Grip {
  Quat q_WT = Quat::Identity();
  unsigned buttons = 0;
};

struct State {
  std::vector<Arm> arms;
  std::optional<Grip> grip;  // the first of them
};

// Error: it is no JSON, or not of that kind. What is missing in it keeps its default; a cursor without a position is left out.
Result<State> read_state(std::string_view text);

// The first message of a session: who we are, the axes we expect, and no force.
std::string first_message(std::string_view arm_id);
// Each of those after it, in W. Pre: finite.
std::string force_message(std::string_view arm_id, const Vec3& force_n);

}  // namespace hapton::haply
