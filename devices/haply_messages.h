#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

// The messages between the Haply Inverse Service and its clients, version 3.5, as JSON texts. All functions are pure.
// Source: the service's public documentation (docs.haply.co/inverseSDK).
namespace hapton::haply {

// The service's axes are x right, y away from the user, z up, with the origin at the device's mounting plate; W's are x right, y up, z
// towards the user, with the origin at the home position of the cursor.
Vec3 to_w(const Vec3& p_m);
Vec3 force_from_w(const Vec3& force_n);
Quat to_w(const Quat& q);

// The version of the service, from its reply at /version. Error: the reply names no version. The messages here are those of 3.5 and later
// versions of 3; describe_version_problem: why the service has to be another version, and what to do, for a person; empty for these
// versions.
struct Version {
  int major = 0;
  int minor = 0;
};
Result<Version> read_version(std::string_view text);
std::string describe_version_problem(const Version& version);

// Where an application put the device: p -> position_m + rotation (scale p). A field is none until a message has it.
struct Placement {
  std::optional<Vec3> position_m;
  std::optional<Quat> rotation;
  std::optional<Vec3> scale;

  // Takes the fields that a newer message has; the others stay.
  void update(const Placement& newer);
  bool is_scaled() const;
  Vec3 inverse(const Vec3& p_m) const;  // ignores the scale; pre: !is_scaled()
  Vec3 turn(const Vec3& vector) const;
};

// One Inverse3 in an inventory or a state.
struct Arm {
  std::string id;
  std::string model;               // inventories only
  std::string firmware;            // inventories only
  Vec3 position_m = Vec3::Zero();  // position of the cursor in the application's axes: after mount and transform
  Placement mount;                 // placement of the device, inventories only
  Placement transform;             // placement of the workspace, applied after the mount
  bool is_calibrated = true;       // also if the message does not tell
};

// How a session places the device. W stays at the device, whatever mount and transform are.
struct Session {
  Placement mount;
  Placement transform;

  void update(const Arm& arm);
  // A scale would make walls stiffer or softer than they are.
  bool is_scaled() const { return mount.is_scaled() || transform.is_scaled(); }
  Vec3 to_w(const Vec3& position_m) const;
  // The force in the application's axes.
  Vec3 force_from_w(const Vec3& force_n) const;
};

// A grip that is held by hand: orientation and buttons.
struct Grip {
  Quat q_WT = Quat::Identity();
  unsigned buttons = 0;
};

struct State {
  std::vector<Arm> arms;
  std::optional<Grip> grip;  // the first grip in the message; a wireless one before others
};

// Error: the text is not a JSON object. What the text lacks keeps its default; an arm without a position or an id is left out.
Result<State> read_state(std::string_view text);

// The first message of a session: who we are, the axes we expect, and no force.
std::string first_message(std::string_view arm_id);
// Each later message of a session: a force in the application's axes. Pre: the force is finite.
std::string force_message(std::string_view arm_id, const Vec3& force_n);

}  // namespace hapton::haply
