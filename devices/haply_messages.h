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

// The version of the service, from what it says at /version. Error: it does not say. The messages here are those from 3.5 on;
// why_unknown: what a person does about another one, empty for those.
struct Version {
  int major = 0;
  int minor = 0;
};
Result<Version> read_version(std::string_view text);
std::string why_unknown(const Version& version);

// Where an application put the device: p -> position_m + rotation (scale p). Fields that were not said are none.
struct Placement {
  std::optional<Vec3> position_m;
  std::optional<Quat> rotation;
  std::optional<Vec3> scale;

  // What is said in a newer message replaces what was known.
  void update(const Placement& newer);
  bool is_scaled() const;
  Vec3 inverse(const Vec3& p_m) const;  // without the scale: pre: not is_scaled
  Vec3 turn(const Vec3& vector) const;
};

// One Inverse3 in an inventory or a state.
struct Arm {
  std::string id;
  std::string model;               // inventories only
  std::string firmware;            // inventories only
  Vec3 position_m = Vec3::Zero();  // of the cursor, in the application's axes: after mount and transform
  Placement mount;                 // of the device, inventories only
  Placement transform;             // of the workspace, on top of it
  bool is_calibrated = true;       // as far as it says
};

// How a session places the device. W stays at the device, whatever mount and transform are.
struct Session {
  Placement mount;
  Placement transform;

  void update(const Arm& arm);
  // A scale would make walls stiffer or softer than they are.
  bool is_scaled() const { return mount.is_scaled() || transform.is_scaled(); }
  Vec3 to_w(const Vec3& position_m) const;
  // In the application's axes.
  Vec3 force_from_w(const Vec3& force_n) const;
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

// Error: it is not JSON, or not of that kind. What is missing in it keeps its default; a cursor without a position is left out.
Result<State> read_state(std::string_view text);

// The first message of a session: who we are, the axes we expect, and no force.
std::string first_message(std::string_view arm_id);
// Each of those after it, in the application's axes. Pre: finite.
std::string force_message(std::string_view arm_id, const Vec3& force_n);

}  // namespace hapton::haply
