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

  // The newest sample after the one before; none until deadline_ns.
  std::optional<DeviceState> next(std::int64_t deadline_ns) noexcept;
  // Replies to the sample handed out last. N, frame W; a force that is not finite is sent as none.
  void reply(const Vec3& force_n) noexcept;
  // No force from now on: replies to the next sample, if one comes soon, with none.
  void release() noexcept {
    if (next(clock().now_ns() + kReleasePatienceNs)) reply(Vec3::Zero());
  }

  const Clock& clock() const noexcept { return connection_->clock(); }
  // False while the hub is away. It may come back: next() continues then.
  bool is_joined() noexcept { return connection_->client().state() == JoinState::joined; }
  std::uint64_t replies() const noexcept { return replies_; }
  // Samples that got no reply because a newer one had come.
  std::uint64_t superseded() const noexcept { return superseded_ + skipped_; }

  // Marks of the recording: any thread requests them and waits, and may do so for longer than the link lives; send_marker, of the link's
  // own thread, sends the one that waits, again until the hub replies.
  std::shared_ptr<Markers> markers() const noexcept { return markers_; }
  void send_marker() noexcept { markers_->send(connection_->client(), clock().now_ns()); }
  // From a sample's arrival to its reply's departure.
  const LatencyHistogram& compute_times() const noexcept { return compute_times_; }

 private:
  static constexpr std::int64_t kReleasePatienceNs = 20 * kNanosecondsPerMillisecond;  // then the force has timed out

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
