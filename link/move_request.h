#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"
#include "link/hub_client.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// What a program can request of an object that it may move (docs/scene-files.md).
struct MoveTarget {
  std::optional<Vec3> position_m = {};  // as position_m of the scene file; none: the pivot stays where it is
  std::optional<Quat> rotation = {};    // as rotation of the scene file; none: the object does not turn
  std::optional<double> over_s = {};    // time that the move takes; none: the least time allowed
};

// A request with a random number. object: its name, or "#N", its number in the scene, from 0. Error, one line: an invalid name, pose or
// time, or neither position nor rotation. RT: no.
Result<MoveRequest> make_move_request(std::string_view object, const MoveTarget& target);

// The time that the move takes, s. Error, one line: why the object does not move.
Result<double> read_reply(const MoveReply& reply);

// Sends a request, again and again until its reply comes, for `seconds` at most. Other messages that arrive meanwhile are dropped. Error:
// as read_reply, or no reply has come. Pre: the client has joined. RT: no.
Result<double> move_object(HubClient& client, const Clock& clock, const MoveRequest& request, double seconds = 3.0);

}  // namespace hapton
