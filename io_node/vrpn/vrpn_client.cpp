#include "io_node/vrpn/vrpn_client.h"

#include <algorithm>
#include <utility>

namespace hapton::vrpn {
namespace {

constexpr std::string_view kPing = "vrpn_Base ping_message";
constexpr std::string_view kWorkspaceRequest = "vrpn_Tracker Request_Tracker_Workspace";
constexpr std::string_view kToRoomRequest = "vrpn_Tracker Request_Tracker_To_Room";
constexpr std::string_view kUnitToSensorRequest = "vrpn_Tracker Request_Unit_To_Sensor";
constexpr std::string_view kRateRequest = "vrpn_Tracker set_update_rate";
constexpr std::string_view kRejection =
    "forces are not accepted from VRPN clients: only the haptics node sends forces (Hapton, docs/vrpn.md)";
constexpr std::string_view kForceDevice = "vrpn_ForceDevice ";

bool contains(const std::vector<std::int32_t>& ids, std::int32_t id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); }

void remember(std::vector<std::int32_t>& ids, std::int32_t id, std::size_t most) {
  if (!contains(ids, id) && ids.size() < most) ids.push_back(id);
}

}  // namespace

bool Client::receive(std::span<const std::byte> bytes, Time now) {
  in_.insert(in_.end(), bytes.begin(), bytes.end());
  if (!is_connected_) {
    if (in_.size() < kCookieBytes) return true;
    if (!take_cookie()) return false;
    introduce(now);
  }
  std::span<const std::byte> rest(in_);
  while (true) {
    Message message;
    const ReadStatus status = read_message(rest, message);
    if (status == ReadStatus::broken) return false;
    if (status == ReadStatus::incomplete) break;
    if (!receive_message(message, now)) return false;
  }
  in_.erase(in_.begin(), in_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return true;
}

bool Client::take_cookie() {
  if (!is_cookie_good(std::span(in_).first(kCookieBytes))) return false;
  in_.erase(in_.begin(), in_.begin() + kCookieBytes);
  return true;
}

void Client::introduce(Time now) {
  is_connected_ = true;
  append_description(out_, kSenderDescription, kOurSender, name_, now, ++sequence_);
  for (std::size_t n = 0; n < kOurTypes.size(); ++n) {
    append_description(out_, kTypeDescription, static_cast<std::int32_t>(n), kOurTypes[n], now, ++sequence_);
  }
}

bool Client::receive_message(const Message& message, Time now) {
  switch (message.type) {
    case kSenderDescription:
      receive_sender(message);
      return true;
    case kTypeDescription:
      receive_type(message);
      return true;
    case kUdpDescription:
      receive_udp(message);
      return true;
    case kDisconnect:
      return false;
    default:
      break;
  }
  if (message.type < 0 || !is_about_us(message.sender)) return true;
  if (ping_type_ == message.type) append_empty(out_, header(OurType::pong, now));
  if (workspace_type_ == message.type) wants_workspace_ = true;
  if (to_room_type_ == message.type) append_to_room(out_, header(OurType::to_room, now));
  if (unit_to_sensor_type_ == message.type) {
    for (const std::int32_t sensor : {kStylus, kProxy}) append_unit_to_sensor(out_, header(OurType::unit_to_sensor, now), sensor);
  }
  if (rate_type_ == message.type) {
    const std::optional<double> rate_hz = number_of(message);
    if (rate_hz && *rate_hz > 0.0) wanted_rate_hz_ = rate_hz;  // false for NaN as well
  }
  if (contains(force_types_, message.type)) reject_force(now);
  return true;
}

// A client that sends forces a thousand times a second is notified once a second.
void Client::reject_force(Time now) {
  ++rejected_forces_;
  if (last_rejection_s_ == now.s) return;
  last_rejection_s_ = now.s;
  append_error_text(out_, header(OurType::text, now), kRejection);
}

// The sender field of a sender description contains the number of the sender that it describes.
void Client::receive_sender(const Message& message) {
  const bool is_us = name_of(message) == name_;
  if (is_us) remember(our_ids_, message.sender, kMaxIds);
  // This number now names another sender.
  if (!is_us) std::erase(our_ids_, message.sender);
}

void Client::receive_type(const Message& message) {
  const std::string_view name = name_of(message);
  if (name == kPing) ping_type_ = message.sender;
  if (name == kWorkspaceRequest) workspace_type_ = message.sender;
  if (name == kToRoomRequest) to_room_type_ = message.sender;
  if (name == kUnitToSensorRequest) unit_to_sensor_type_ = message.sender;
  if (name == kRateRequest) rate_type_ = message.sender;
  if (name.starts_with(kForceDevice)) remember(force_types_, message.sender, kMaxIds);
}

void Client::receive_udp(const Message& message) {
  // An IPv6 address as a number has 45 characters; names are not resolved.
  constexpr std::size_t kLongestAddress = 64;
  const auto* const text = reinterpret_cast<const char*>(message.body.data());
  const std::string_view address(text, std::find(text, text + message.body.size(), '\0') - text);
  if (address.size() > kLongestAddress || message.sender < 1 || message.sender > 65535) return;
  udp_request_ = UdpRequest{std::string(address), static_cast<std::uint16_t>(message.sender)};
}

bool Client::is_about_us(std::int32_t sender) const { return contains(our_ids_, sender); }

bool Client::take_workspace_request() { return std::exchange(wants_workspace_, false); }

}  // namespace hapton::vrpn
