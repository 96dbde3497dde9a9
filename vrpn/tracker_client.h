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

// The protocol state of one connection to a VRPN server, for one sensor of one device and its buttons. Memory and time are bounded for any
// bytes received. It has no socket and no clock. RT: no. Threads: one.
class TrackerClient {
 public:
  // The largest number of names of the server's devices that are kept for the log; further ones are ignored.
  static constexpr std::size_t kMaxDevices = 8;

  // device: the name before the '@' in NAME@HOST.
  TrackerClient(std::string_view device, std::int32_t sensor);

  // Parses received bytes. False: the server has ended the connection, or this is not VRPN; close it.
  bool receive(std::span<const std::byte> bytes);

  // The server has sent a valid cookie; our cookie and the name of the tracker are in out().
  bool is_connected() const { return is_connected_; }
  // The newest pose since the last call; none if there is no new one.
  std::optional<TrackerPose> take_newest();
  // Which of the first 32 buttons of the device are down, one bit each (bit 0: button 0); up until the server reports otherwise.
  std::uint32_t buttons() const { return buttons_; }
  // Which of them the server has reported, in the same way.
  std::uint32_t reported_buttons() const { return reported_buttons_; }
  // Requests a reply from the tracker (vrpn_Base ping). Pre: is_connected().
  void ping();
  // The devices that the server has named so far, in one line for the log: printable characters only.
  std::string describe_devices() const;
  // Bytes to send; the caller sends and removes them.
  Bytes& out() { return bytes_to_send_; }

 private:
  bool take_cookie();
  bool receive_message(const Message& message);
  void receive_sender(const Message& message);
  void receive_type(const Message& message);
  void receive_position(const Message& message);
  void receive_buttons(const Message& message);

  std::string device_;
  std::int32_t sensor_;
  Bytes received_bytes_;
  Bytes bytes_to_send_;
  bool is_connected_ = false;
  std::uint32_t sequence_ = 0;
  // The server's numbers for the device and for the types of messages that are read; none: the server has not named it yet.
  std::optional<std::int32_t> tracker_id_;
  std::optional<std::int32_t> position_type_;
  std::optional<std::int32_t> change_type_;
  std::optional<std::int32_t> states_type_;
  std::vector<std::string> devices_;
  std::optional<TrackerPose> newest_;
  std::uint32_t buttons_ = 0;
  std::uint32_t reported_buttons_ = 0;
};

}  // namespace hapton::vrpn
