#include "link/move_request.h"

#include <algorithm>
#include <cmath>

#include "link/object_choice.h"
#include "link/random_id.h"
#include "link/wire_fields.h"

namespace hapton {
namespace {

constexpr std::int64_t kRepeatMoveNs = 100 * kNanosecondsPerMillisecond;  // a datagram may be lost

Result<void> check(const MoveTarget& target) {
  if (!target.position_m && !target.rotation) return fail("give a position, a rotation, or both");
  if (target.position_m && !(target.position_m->allFinite() && target.position_m->cwiseAbs().maxCoeff() <= kMaxWireMagnitude)) {
    return fail("a position is three numbers in metres, up to {:g}", kMaxWireMagnitude);
  }
  if (target.rotation && !(std::abs(target.rotation->norm() - 1.0) <= kUnitTolerance)) {
    return fail("a rotation is a quaternion w, x, y, z of length 1, not {:.6g}", target.rotation->norm());
  }
  if (target.over_s && !(*target.over_s > 0.0 && *target.over_s <= MoveRequest::kMaxSeconds)) {
    return fail("a move takes a time above 0 s and up to {:g} s, not {:g} s", MoveRequest::kMaxSeconds, *target.over_s);
  }
  return {};
}

}  // namespace

Result<MoveRequest> make_move_request(std::string_view object, const MoveTarget& target) {
  if (const auto checked = check(target); !checked) return tl::unexpected(checked.error());
  MoveRequest request{.request = static_cast<std::uint32_t>(make_random_id()) | 1U,
                      .p_m = target.position_m,
                      .q = target.rotation,
                      .over_s = target.over_s};
  if (const auto chosen = choose_object(object, request.object, request.number); !chosen) return tl::unexpected(chosen.error());
  return request;
}

Result<double> read_reply(const MoveReply& reply) {
  if (reply.rejection[0] != '\0') return fail("the haptics node rejected it: {}", reply.rejection.data());
  return reply.over_s;
}

Result<double> move_object(HubClient& client, const Clock& clock, const MoveRequest& request, double seconds) {
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  Datagram datagram;
  for (std::int64_t now_ns = clock.now_ns(); now_ns < end_ns; now_ns = clock.now_ns()) {
    client.send(request);
    while (client.receive(datagram, std::min(end_ns, now_ns + kRepeatMoveNs))) {
      const auto* reply = std::get_if<MoveReply>(&datagram.message);
      if (reply != nullptr && reply->request == request.request) return read_reply(*reply);
    }
  }
  return fail("no haptics node replied within {:g} s; start haptics_node, or update it to this version", seconds);
}

}  // namespace hapton
