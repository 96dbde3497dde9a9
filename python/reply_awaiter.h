#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string_view>

#include "link/hub_client.h"
#include "link/marker_request.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton::python {

// Sends one request at a time, and repeats it until the reply with its number comes, because a datagram may be lost. Threads: any for
// request; the one that owns the connection for send and take.
template <class Request, class Reply>
class ReplyAwaiter {
 public:
  // Blocks until other requests have ended, then until the reply comes or the timeout ends. None: no reply came.
  std::optional<Reply> request(const Request& request, std::chrono::seconds timeout) {
    const std::scoped_lock one_at_a_time(requesting_);
    std::unique_lock lock(mutex_);
    request_ = request;
    reply_.reset();
    next_send_ns_ = 0;
    came_.wait_for(lock, timeout, [&] { return reply_.has_value(); });
    request_.reset();
    return reply_;
  }

  // Does not wait: if another thread has the lock, a later call sends.
  void send(HubClient& client, std::int64_t now_ns) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || !request_ || reply_ || now_ns < next_send_ns_) return;
    next_send_ns_ = now_ns + 100 * kNanosecondsPerMillisecond;
    client.send(*request_);
  }

  void take(const Message& message) {
    const auto* reply = std::get_if<Reply>(&message);
    if (reply == nullptr) return;
    const std::scoped_lock lock(mutex_);
    if (!request_ || reply->request != request_->request) return;
    reply_ = *reply;
    came_.notify_all();
  }

 private:
  std::mutex requesting_;
  std::mutex mutex_;  // for all members below
  std::condition_variable came_;
  std::optional<Request> request_;
  std::optional<Reply> reply_;
  std::int64_t next_send_ns_ = 0;
};

// Requests to mark a recording.
using Markers = ReplyAwaiter<Marker, MarkerReply>;
// Blocks until the mark is recorded. Returns its sample's number. Error, one line: a text that is not allowed, a rejection, or no reply.
inline Result<std::uint64_t> request_mark(Markers& markers, std::string_view text) {
  constexpr std::chrono::seconds kMarkTimeout{2};
  const auto marker = make_marker(text);
  if (!marker) return tl::unexpected(marker.error());
  const auto reply = markers.request(*marker, kMarkTimeout);
  if (!reply) return fail("no reply from the hub in {} s: it is gone, or of an earlier version", kMarkTimeout.count());
  return read_reply(*reply);
}

}  // namespace hapton::python
