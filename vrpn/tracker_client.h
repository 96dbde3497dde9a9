#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "vrpn/vrpn_wire.h"

namespace hapton::vrpn {

// The pose of a tracker's sensor. Frame: the tracker's. Units: m. All numbers are finite, and q has length 1.
struct TrackerPose {
  Vec3 p_m = Vec3::Zero();
  Quat q = Quat::Identity();
};

// The protocol state of one connection to a VRPN server, of which one sensor of one tracker is of interest. For any bytes, memory and time
// are bounded. Pure: no socket, no clock.
class TrackerClient {
 public:
  // Names of devices that are kept for the log.
  static constexpr std::size_t kMostDevices = 8;

  // device: the name before the '@'.
  TrackerClient(std::string_view device, std::int32_t sensor);

  // Parses received bytes. False: the server said goodbye, or this is not VRPN; close it.
  bool receive(std::span<const std::byte> bytes);

  // It has sent a valid cookie and got ours and our name for the tracker.
  bool is_connected() const { return is_connected_; }
  // The newest pose since the last call.
  std::optional<TrackerPose> take_newest();
  // Asks the tracker for a sign of life. Pre: is_connected().
  void ping();
  // The devices that the server has named so far, as a line for people: printable letters only.
  std::string describe_devices() const;
  // Bytes to send; the caller sends and clears them.
  Bytes& out() { return out_; }

 private:
  bool take_cookie();
  bool receive_message(const Message& message);
  void receive_sender(const Message& message);
  void receive_type(const Message& message);
  void receive_position(const Message& message);

  std::string device_;
  std::int32_t sensor_;
  Bytes in_;
  Bytes out_;
  bool is_connected_ = false;
  std::uint32_t sequence_ = 0;
  // The server's numbers for the tracker and for what it reports.
  std::optional<std::int32_t> tracker_;
  std::optional<std::int32_t> position_type_;
  std::vector<std::string> devices_;
  std::optional<TrackerPose> newest_;
};

}  // namespace hapton::vrpn
