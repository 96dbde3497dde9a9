#pragma once

#include <memory>
#include <optional>

#include "link/hub_connection.h"
#include "python/reply_awaiter.h"
#include "runtime/latency_histogram.h"

namespace hapton::python {

// The connection of a haptics node: hands out the newest device sample and sends the reply to it. RT: next and reply yes; open set-up only.
// Threads: one.
class NodeLink {
 public:
  // Error, one line: as HubConnection::open, or no hub accepts a haptics node.
  static Result<std::unique_ptr<NodeLink>> open(const std::string& hub, const std::string& key_file);

  // The newest sample that has come since the last call. None: none came until deadline_ns.
  std::optional<DeviceState> next(std::int64_t deadline_ns) noexcept;
  // Replies to the sample handed out last. N, frame W; a force that is not finite is sent as zero.
  void reply(const Vec3& force_n) noexcept;
  // Ends the force: replies to the next sample with zero, if one comes within kReleasePatienceNs.
  void release() noexcept {
    if (next(clock().now_ns() + kReleasePatienceNs)) reply(Vec3::Zero());
  }

  const Clock& clock() const noexcept { return connection_->clock(); }
  // False while the hub is away. When it comes back, next() continues.
  bool is_joined() noexcept { return connection_->client().state() == JoinState::joined; }
  std::uint64_t replies() const noexcept { return replies_; }
  // Samples that got no reply because a newer one had come.
  std::uint64_t superseded() const noexcept { return superseded_ + skipped_; }

  // Requests to mark the recording. Any thread may make one and wait for the reply, also beyond the life of the link. The link's own thread
  // calls send_marker, which sends the request that waits, and repeats it until the hub replies.
  std::shared_ptr<Markers> markers() const noexcept { return markers_; }
  void send_marker() noexcept { markers_->send(connection_->client(), clock().now_ns()); }
  // Times from a sample's arrival until its reply was sent.
  const LatencyHistogram& compute_times() const noexcept { return compute_times_; }

 private:
  static constexpr std::int64_t kReleasePatienceNs = 20 * kNanosecondsPerMillisecond;  // after this the hub has released the force

  explicit NodeLink(std::unique_ptr<HubConnection> connection) : connection_(std::move(connection)) {}

  std::unique_ptr<HubConnection> connection_;
  Datagram datagram_;
  ForceCommand command_;
  DeviceState state_;
  std::int64_t arrival_ns_ = 0;
  std::uint32_t skipped_ = 0;
  std::uint64_t replies_ = 0;
  std::uint64_t superseded_ = 0;
  LatencyHistogram compute_times_;
  std::shared_ptr<Markers> markers_ = std::make_shared<Markers>();
};

}  // namespace hapton::python
