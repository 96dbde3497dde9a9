#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "link/hub_client.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// Sends the shapes of a program to objects that programs deform (docs/scene-files.md): each in parts, a few every millisecond, so that
// neither the hub nor the haptics node gets many at once. If several shapes of an object wait, only the newest of them is sent.
//
// RT: no. Threads: one for send and take, which owns the connection; any for the others.
class ShapeOutbox {
 public:
  // Parts sent every kEveryNs: as many as the hub passes on from one sender (RequestHandler::kShapePartsPerSecond).
  static constexpr std::size_t kPartsAtOnce = 4;
  static constexpr std::int64_t kEveryNs = kNanosecondsPerMillisecond;
  static constexpr std::int64_t kRepeatNs = 300 * kNanosecondsPerMillisecond;  // until a needed shape is sent again

  ShapeOutbox();

  // Adds the next shape of an object, which is given by its name or as "#N", its number in the scene, from 0. One displacement a vertex, in
  // m of the mesh, before scale and pose. over_s: least time of the motion. is_needed: sent again until its reply comes or a newer shape of
  // the object is given. Returned: the number of the shape. Error, one line: what is wrong with the object or the shape.
  Result<std::uint32_t> give(std::string_view object, std::span<const ShapePart::Displacement> displacements_m, double over_s,
                             bool is_needed = false);

  // Sends the parts that are due. Pre: the client has joined as a tool or a vision node.
  void send(HubClient& client, std::int64_t now_ns);
  // Takes any message that was received: replies to these shapes are kept.
  void take(const Message& message);
  // True if all has been sent, and nothing that is needed waits for its reply.
  bool is_empty() const;

  // The reply to a shape; none if it has not come, or is not among the last kMaxReplies.
  std::optional<ShapeReply> find_reply(std::uint32_t shape) const;
  // Waits for the reply: the time of the motion to the shape, s. Error, one line: why the object does not take it; or as give_up().
  Result<double> wait_for(std::uint32_t shape, double seconds);
  // Ends a wait of `seconds`: returns a reply that came at the last moment, as wait_for() does; else the error that there was none, and the
  // shape is no longer sent.
  Result<double> give_up(std::uint32_t shape, double seconds);

 private:
  struct Shape {
    ShapeRequest head;
    std::vector<ShapePart::Displacement> displacements_m;
    bool is_needed = false;
    std::uint32_t next = 0;      // the first vertex that is to be sent
    std::int64_t repeat_ns = 0;  // when it is sent again
  };

  static constexpr std::size_t kMaxReplies = 64;

  // Pre of both: mutex_ is locked.
  const ShapeReply* reply_to(std::uint32_t shape) const;  // null: none
  Result<double> end_wait(std::uint32_t shape, double seconds);
  bool is_done(const Shape& shape) const { return shape.next >= shape.displacements_m.size() && !shape.is_needed; }

  mutable std::mutex mutex_;  // guards all members below
  std::condition_variable reply_arrived_;
  std::uint32_t stream_;
  std::uint32_t newest_ = 0;
  std::vector<Shape> shapes_;        // to be sent; for each object at most one that has begun, and one that waits
  std::vector<ShapeReply> replies_;  // the newest
  std::int64_t next_send_ns_ = 0;
};

// What a reply says: the time that the motion takes, s, or as an error why the object does not take the shape.
Result<double> read_reply(const ShapeReply& reply);

// For a program that does nothing else meanwhile: gives a shape, and sends it until its reply comes. Other messages that arrive are
// dropped. Error: as give() and wait_for(). Pre: the client has joined.
Result<double> deform_object(HubClient& client, const Clock& clock, ShapeOutbox& outbox, std::string_view object,
                             std::span<const ShapePart::Displacement> displacements_m, double over_s, double seconds = 3.0);

}  // namespace hapton
