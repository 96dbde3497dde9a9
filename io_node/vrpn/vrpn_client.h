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

// The types of message that we send; their values are the numbers that we give them in the protocol.
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

// The protocol state of one VRPN client: parses its messages and puts the replies into out(). Memory and time are bounded whatever bytes
// come. Pure: no socket, no clock. Forces that the client requests (vrpn_ForceDevice Plane, Force_Field and the rest) are rejected and
// counted, and the client is notified by a text message, once a second at most: see docs/vrpn.md.
class Client {
 public:
  // name: the name of the device, which clients write before the '@'.
  explicit Client(std::string_view name) : name_(name) { append_cookie(out_); }

  // Parses received bytes. False: the client has ended the connection, or its messages are invalid; close it.
  bool receive(std::span<const std::byte> bytes, Time now);

  // The client has sent a valid cookie, and the names that we use were put into out().
  bool is_connected() const { return is_connected_; }
  // A request of the client for UDP: the port, and the address as the client wrote it. The caller decides whether to follow it.
  struct UdpRequest {
    std::string address;
    std::uint16_t port = 0;
  };
  const std::optional<UdpRequest>& udp_request() const { return udp_request_; }
  std::uint64_t rejected_forces() const { return rejected_forces_; }
  // Reports a second that the client wants; none: it has requested no rate.
  std::optional<double> wanted_rate_hz() const { return wanted_rate_hz_; }
  // True: the client has requested the workspace since the last call.
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

  // Most numbers kept of one kind: a client may describe names again and again, but has no reason to describe more.
  static constexpr std::size_t kMaxIds = 128;

  std::string name_;
  Bytes in_;
  Bytes out_;
  bool is_connected_ = false;
  std::uint32_t sequence_ = 0;
  std::vector<std::int32_t> our_ids_;  // the client's numbers for our device
  std::vector<std::int32_t> force_types_;
  std::optional<std::int32_t> ping_type_;
  std::optional<std::int32_t> workspace_type_;
  std::optional<std::int32_t> to_room_type_;
  std::optional<std::int32_t> unit_to_sensor_type_;
  std::optional<std::int32_t> rate_type_;
  std::optional<double> wanted_rate_hz_;
  std::optional<std::uint32_t> last_rejection_s_;  // when the client was last notified that forces are rejected
  bool wants_workspace_ = false;
  std::optional<UdpRequest> udp_request_;
  std::uint64_t rejected_forces_ = 0;
};

}  // namespace hapton::vrpn
