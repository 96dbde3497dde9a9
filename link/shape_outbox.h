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

// Sends the shapes of a program to objects that programs deform (docs/scene-files.md): each in parts, a few in a millisecond, so that
// neither the hub nor the haptics node has many at once. Of the shapes of an object that wait, the newest is sent.
//
// RT: no. Threads: one for send and take, which owns the connection; any for the others.
class ShapeOutbox {
 public:
  // Each in kEveryNs: as many as the hub passes on of one sender (RequestHandler::kShapePartsPerSecond).
  static constexpr std::size_t kPartsAtOnce = 4;
  static constexpr std::int64_t kEveryNs = kNanosecondsPerMillisecond;
  static constexpr std::int64_t kRepeatNs = 300 * kNanosecondsPerMillisecond;  // a shape that is waited for

  ShapeOutbox();

  // The next shape of an object: its name, or "#N", its number in the scene, from 0. One displacement for each vertex, in m of the mesh,
  // before scale and pose. over_s: the time that the surface takes to it at least. is_needed: sent again until its reply comes. Returned:
  // the number of the shape. Error, one line: what a shape must not have.
  Result<std::uint32_t> give(std::string_view object, std::span<const ShapePart::Displacement> displacements_m, double over_s,
                             bool is_needed = false);

  // The parts that are due. Pre: the client has joined as a tool or a vision node.
  void send(HubClient& client, std::int64_t now_ns);
  // Whatever came: replies are kept.
  void take(const Message& message);
  // All has been sent, and nothing that is needed waits for its reply.
  bool is_empty() const;

  // Of the newest shapes that have one.
  std::optional<ShapeReply> find_reply(std::uint32_t shape) const;
  // The time that the motion to a shape takes, s. Error, one line: why the object does not take it; there was no reply in that time.
  Result<double> wait_for(std::uint32_t shape, double seconds);
  // The end of a wait of that time: a reply that came at the last moment, as wait_for() returns it; else the error, and the shape is not
  // sent any more.
  Result<double> give_up(std::uint32_t shape, double seconds);

 private:
  struct Shape {
    ShapeRequest head;
    std::vector<ShapePart::Displacement> displacements_m;
    bool is_needed = false;
    std::uint32_t next = 0;      // the first vertex that is to be sent
    std::int64_t repeat_ns = 0;  // sent again then
  };

  static constexpr std::size_t kMaxReplies = 64;

  // Pre of both: locked.
  const ShapeReply* reply_to(std::uint32_t shape) const;  // null: none
  Result<double> end_wait(std::uint32_t shape, double seconds);
  bool is_done(const Shape& shape) const { return shape.next >= shape.displacements_m.size() && !shape.is_needed; }

  mutable std::mutex mutex_;  // of all below
  std::condition_variable came_;
  std::uint32_t stream_;
  std::uint32_t newest_ = 0;
  std::vector<Shape> shapes_;        // to be sent; of one object at most one that has begun, and one that waits
  std::vector<ShapeReply> replies_;  // the newest
  std::int64_t next_send_ns_ = 0;
};

// How such a reply reads: the time that the motion takes, s, or why there is none.
Result<double> read_reply(const ShapeReply& reply);

// For a program that does nothing else meanwhile: gives a shape, and sends it until its reply comes. Other messages that arrive are
// dropped. Error: as give() and wait_for(). Pre: the client has joined.
Result<double> deform_object(HubClient& client, const Clock& clock, ShapeOutbox& outbox, std::string_view object,
                             std::span<const ShapePart::Displacement> displacements_m, double over_s, double seconds = 3.0);

}  // namespace hapton
