#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/math/types.h"

// VRPN's wire format, version 07.xx: each side sends a cookie, then messages of a 24-byte header and a body padded to 8 bytes; big-endian.
// Pure: bytes in, bytes out. Source: the published sources of VRPN (vrpn_Connection.C, vrpn_Tracker.C, vrpn_Button.C, vrpn_Analog.C,
// vrpn_ForceDevice.C), read for their format.
namespace hapton::vrpn {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kCookieBytes = 24;
constexpr std::size_t kHeaderBytes = 24;
constexpr std::size_t kPadding = 8;
// The longest message that we accept from a client: far more than any that our server needs.
constexpr std::size_t kMaxMessageBytes = 16384;
// The longest message from a server: VRPN's own limit.
constexpr std::size_t kMaxServerMessageBytes = 64000;
// The longest datagram with messages: VRPN's own limit.
constexpr std::size_t kMaxDatagramBytes = 1472;

// The message types that VRPN itself defines; they are negative.
constexpr std::int32_t kSenderDescription = -1, kTypeDescription = -2, kUdpDescription = -3, kLogDescription = -4, kDisconnect = -5;

// Time of day, since 1970.
struct Time {
  std::uint32_t s = 0;
  std::uint32_t us = 0;
};

struct Header {
  std::int32_t sender = 0;
  std::int32_t type = 0;
  Time time;
  std::uint32_t sequence = 0;
};

// "vrpn: ver. 07.38  0": logging not requested.
void append_cookie(Bytes& out);
// Whether we support the sender's version: equal up to the last dot. Pre: cookie.size() == kCookieBytes.
bool is_cookie_good(std::span<const std::byte> cookie);

// Tells the receiver which number `id` the sender uses for a name. kind: kSenderDescription or kTypeDescription.
void append_description(Bytes& out, std::int32_t kind, std::int32_t id, std::string_view name, Time time, std::uint32_t sequence);

// vrpn_Tracker Pos_Quat: the pose of a sensor; m, on the wire the quaternion as x, y, z, w.
void append_position(Bytes& out, const Header& header, std::int32_t sensor, const Vec3& p_m, const Quat& q);
// vrpn_Tracker Velocity of sensor 0: its velocity in m/s, and its rotation in dt_s seconds.
void append_velocity(Bytes& out, const Header& header, const Vec3& v_m_per_s, const Quat& turn, double dt_s);
// vrpn_Tracker Workspace: opposite corners of the tracker's workspace.
void append_workspace(Bytes& out, const Header& header, const Vec3& low_m, const Vec3& high_m);
// vrpn_Tracker To_Room, with the identity: the tracker's frame is that of the room.
void append_to_room(Bytes& out, const Header& header);
// vrpn_Tracker Unit_To_Sensor, with the identity: the sensor's frame is that of its unit.
void append_unit_to_sensor(Bytes& out, const Header& header, std::int32_t sensor);
// vrpn_Button Change.
void append_button_change(Bytes& out, const Header& header, std::int32_t button, bool is_down);
// vrpn_Button States: the states of buttons 0 to count - 1, from the lowest bits of `buttons`. Pre: count is 0 to 32.
void append_button_states(Bytes& out, const Header& header, std::uint32_t buttons, std::int32_t count);
// vrpn_Analog Channel.
void append_analog(Bytes& out, const Header& header, std::span<const double> channels);
// vrpn_ForceDevice Force, N.
void append_force(Bytes& out, const Header& header, const Vec3& force_n);
// vrpn_ForceDevice Force_Error.
void append_force_error(Bytes& out, const Header& header, std::int32_t error);
// vrpn_ForceDevice SCP, the surface contact point; zeros, also the quaternion, without contact.
void append_contact_point(Bytes& out, const Header& header, const Vec3& p_m, const Quat& q, bool is_contact);
// vrpn_Base text_message with the severity "error". Longer texts are cut.
void append_error_text(Bytes& out, const Header& header, std::string_view text);
// A message without a body, as vrpn_Base ping_message and pong_message are.
void append_empty(Bytes& out, const Header& header);

// A received message. Its body refers to the bytes that it was read from.
struct Message {
  std::int32_t sender = 0;
  std::int32_t type = 0;
  std::span<const std::byte> body;
};

enum class ReadStatus : std::uint8_t {
  message,
  incomplete,  // the rest has not arrived yet
  broken,      // no valid message: ignore the sender from now on
};

// Reads one message and removes it from the front of bytes. A message longer than most_bytes is broken.
ReadStatus read_message(std::span<const std::byte>& bytes, Message& into, std::size_t most_bytes = kMaxMessageBytes);

// The number in a body that consists of one number; none: the body has another length.
std::optional<double> number_of(const Message& message);

// A sensor's pose in the tracker's frame, as received: not checked. Units: m.
struct SensorPose {
  std::int32_t sensor = 0;
  Vec3 p_m = Vec3::Zero();
  Quat q = Quat::Identity();
};
// The pose in a vrpn_Tracker Pos_Quat; none: the body has another length.
std::optional<SensorPose> position_of(const Message& message);

// The number in a vrpn_Button Change and whether that button is down; none: the body has another length.
struct ButtonChange {
  std::int32_t button = 0;
  bool is_down = false;
};
std::optional<ButtonChange> button_of(const Message& message);
// The first 32 buttons of a vrpn_Button States, one bit each; none: the body's length does not fit its number of buttons.
std::optional<std::uint32_t> buttons_of(const Message& message);

// The name in the body of a description, without its terminating zero; empty if the body is not well-formed or the name is too long.
std::string_view name_of(const Message& description);

}  // namespace hapton::vrpn
