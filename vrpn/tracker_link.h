#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/stream_endpoint.h"
#include "vrpn/tracker_client.h"

namespace hapton::vrpn {

// A tracker as VRPN's programs name it.
struct TrackerName {
  std::string device;
  std::string host;  // HOST or HOST:PORT
};
// NAME@HOST, NAME@HOST:PORT, or either with tcp:// before HOST. Error: one line.
Result<TrackerName> parse_tracker_name(std::string_view text);

// A connection to the VRPN server of another program, over TCP alone: made again by itself whenever it is gone. RT: no. Threads: one.
// Times: CLOCK_MONOTONIC, ns.
class TrackerLink final : private StreamEndpoint::Listener {
 public:
  static constexpr std::uint16_t kServerPort = 3883;
  // From one attempt to connect to the next one.
  static constexpr std::int64_t kRetryNs = 1'000'000'000;
  // Time without a message after which the server gets a ping ...
  static constexpr std::int64_t kPingNs = 1'000'000'000;
  // ... and after which the connection is closed and made again.
  static constexpr std::int64_t kReceiveTimeoutNs = 5'000'000'000;

  // Begins to connect. The server need not be there, now or at any time. Error: a host that has no address.
  static Result<std::unique_ptr<TrackerLink>> open(const TrackerName& name, std::int32_t sensor);

  // Takes what has arrived and returns at once. The newest pose since the last call; none: there is none.
  std::optional<TrackerPose> take_newest(std::int64_t now_ns);

  // Buttons of the device that are down, one bit each (TrackerClient::buttons), as of the last take_newest; 0 without a connection.
  std::uint32_t buttons() const { return client_ ? client_->buttons() : 0; }

  // The server has replied in VRPN.
  bool is_connected() const { return client_ && client_->is_connected(); }
  // Of the server: see TrackerClient.
  std::string describe_devices() const { return client_ ? client_->describe_devices() : std::string(); }

 private:
  TrackerLink(std::unique_ptr<StreamEndpoint> streams, const Address& server, std::string device, std::int32_t sensor);
  void on_connected(StreamEndpoint::Id id, const Address& peer) override;
  void on_bytes(StreamEndpoint::Id id, std::span<const std::byte> bytes) override;
  void on_closed(StreamEndpoint::Id id) override;
  void on_datagram(const Address&, std::span<const std::byte>) override {}
  void keep_connected(std::int64_t now_ns);
  void send_pending();

  std::unique_ptr<StreamEndpoint> streams_;
  Address server_;
  std::string device_;
  std::int32_t sensor_;
  std::optional<TrackerClient> client_;  // of the present connection
  StreamEndpoint::Id id_ = 0;            // 0: none
  bool has_arrived_ = false;             // bytes, since they were last looked for
  std::int64_t received_ns_ = 0;         // the newest bytes, or the beginning of the connection
  std::int64_t asked_ns_ = 0;
  std::int64_t retry_ns_ = 0;
};

}  // namespace hapton::vrpn
