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

// The name of a tracker, as users of VRPN write it.
struct TrackerName {
  std::string device;
  std::string host;  // HOST or HOST:PORT
};
// NAME@HOST, NAME@HOST:PORT, or either with tcp:// before HOST. Error: one line.
Result<TrackerName> parse_tracker_name(std::string_view text);

// A connection to the VRPN server of another program, over TCP alone. If it is lost, take_newest() makes it again. RT: no. Threads: one.
// Times: CLOCK_MONOTONIC, ns.
class TrackerLink final : private StreamEndpoint::Listener {
 public:
  static constexpr std::uint16_t kServerPort = 3883;
  // Time from one attempt to connect to the next one.
  static constexpr std::int64_t kRetryNs = 1'000'000'000;
  // Time without a message after which the server gets a ping ...
  static constexpr std::int64_t kPingNs = 1'000'000'000;
  // ... and after which the connection is closed and made again.
  static constexpr std::int64_t kReceiveTimeoutNs = 5'000'000'000;

  // Prepares the connection, which take_newest() makes. The server need not run. Error: the host has no address, or no socket is available.
  static Result<std::unique_ptr<TrackerLink>> open(const TrackerName& name, std::int32_t sensor);

  // Connects if necessary, reads what has arrived and does not wait. Returns the newest pose since the last call; none: no new one came.
  std::optional<TrackerPose> take_newest(std::int64_t now_ns);

  // Buttons of the device that are down, one bit each (TrackerClient::buttons), at the last take_newest(); 0 without a connection.
  std::uint32_t buttons() const { return client_ ? client_->buttons() : 0; }
  // Which of them the server has reported since the connection was made; 0 without a connection.
  std::uint32_t reported_buttons() const { return client_ ? client_->reported_buttons() : 0; }

  // Whether the server has replied with a valid VRPN cookie.
  bool is_connected() const { return client_ && client_->is_connected(); }
  // The devices that the server has named, see TrackerClient; empty without a connection.
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
  bool has_arrived_ = false;             // something has arrived in the current read
  std::int64_t received_ns_ = 0;         // the newest bytes, or the beginning of the connection
  std::int64_t last_ping_ns_ = 0;
  std::int64_t retry_ns_ = 0;
};

}  // namespace hapton::vrpn
