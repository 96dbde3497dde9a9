#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "vrpn/vrpn_wire.h"

namespace hapton::vrpn {

// What we say, by the numbers that we give our types.
enum class OurType : std::int32_t {
  pong,
  position,
  velocity,
  workspace,
  button_change,
  button_states,
  analog,
  force,
  force_error,
  to_room,
  unit_to_sensor,
  contact_point,
  text
};
constexpr std::array<std::string_view, 13> kOurTypes = {
    "vrpn_Base pong_message",       "vrpn_Tracker Pos_Quat", "vrpn_Tracker Velocity",       "vrpn_Tracker Workspace",
    "vrpn_Button Change",           "vrpn_Button States",    "vrpn_Analog Channel",         "vrpn_ForceDevice Force",
    "vrpn_ForceDevice Force_Error", "vrpn_Tracker To_Room",  "vrpn_Tracker Unit_To_Sensor", "vrpn_ForceDevice SCP",
    "vrpn_Base text_message"};
constexpr std::int32_t kStylus = 0, kProxy = 1;  // sensors
constexpr std::int32_t kOurSender = 0;

// The protocol state of one VRPN client: parses its messages and puts the replies into out(). For any bytes, memory and time are bounded.
// Pure: no socket, no clock. Forces that it requests (vrpn_ForceDevice Plane, Force_Field and the rest) are rejected and counted, and the
// client is notified by a text message, once a second at most: see docs/vrpn.md.
class Client {
 public:
  // name: of the device, what clients write before the '@'.
  explicit Client(std::string_view name) : name_(name) { append_cookie(out_); }

  // Parses received bytes. False: the client has ended the connection, or its messages are invalid; close it.
  bool receive(std::span<const std::byte> bytes, Time now);

  // It has sent a valid cookie and got our names.
  bool is_connected() const { return is_connected_; }
  // A request for UDP: the port, and the address as it wrote it. The caller decides whether to follow.
  struct UdpRequest {
    std::string address;
    std::uint16_t port = 0;
  };
  const std::optional<UdpRequest>& udp_request() const { return udp_request_; }
  std::uint64_t rejected_forces() const { return rejected_forces_; }
  // Reports a second that it wants; none: it has said nothing.
  std::optional<double> wanted_rate_hz() const { return wanted_rate_hz_; }
  // Wants to know the workspace since the last call.
  bool take_workspace_request();

  Header header(OurType type, Time time) { return {kOurSender, static_cast<std::int32_t>(type), time, ++sequence_}; }
  // Bytes to send by TCP; the caller sends and clears them.
  Bytes& out() { return out_; }

 private:
  bool take_cookie();
  bool receive_message(const Message& message, Time now);
  void receive_sender(const Message& message);
  void receive_type(const Message& message);
  void receive_udp(const Message& message);
  void introduce(Time now);
  void reject_force(Time now);
  bool is_about_us(std::int32_t sender) const;

  // Names may be described again and again: no more are kept than a client has reason to.
  static constexpr std::size_t kMaxIds = 128;

  std::string name_;
  Bytes in_;
  Bytes out_;
  bool is_connected_ = false;
  std::uint32_t sequence_ = 0;
  std::vector<std::int32_t> us_;  // its numbers for our device
  std::vector<std::int32_t> force_types_;
  std::optional<std::int32_t> ping_type_;
  std::optional<std::int32_t> workspace_type_;
  std::optional<std::int32_t> to_room_type_;
  std::optional<std::int32_t> unit_to_sensor_type_;
  std::optional<std::int32_t> rate_type_;
  std::optional<double> wanted_rate_hz_;
  std::optional<std::uint32_t> told_s_;  // when it was last notified that forces are rejected
  bool wants_workspace_ = false;
  std::optional<UdpRequest> udp_request_;
  std::uint64_t rejected_forces_ = 0;
};

}  // namespace hapton::vrpn
