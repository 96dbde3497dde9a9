#include "vrpn/tracker_client.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton::vrpn {
namespace {

constexpr std::string_view kPosition = "vrpn_Tracker Pos_Quat";
constexpr std::string_view kButtonChange = "vrpn_Button Change";
constexpr std::string_view kButtonStates = "vrpn_Button States";
constexpr std::string_view kPing = "vrpn_Base ping_message";
// The ids that we define for our own sender and message type.
constexpr std::int32_t kSender = 0, kPingType = 0;

// A quaternion in single precision, or a mean of several, is not exactly of unit length. Outside these bounds it is not a rotation.
constexpr double kMinQuaternionNorm = 0.5, kMaxQuaternionNorm = 2.0;

std::string printable(std::string_view name) {
  std::string text(name);
  std::replace_if(
      text.begin(), text.end(), [](char letter) { return letter < ' ' || letter > '~'; }, '?');
  return text;
}

}  // namespace

TrackerClient::TrackerClient(std::string_view device, std::int32_t sensor) : device_(device), sensor_(sensor) {
  append_cookie(bytes_to_send_);
}

bool TrackerClient::receive(std::span<const std::byte> bytes) {
  received_bytes_.insert(received_bytes_.end(), bytes.begin(), bytes.end());
  if (!is_connected_) {
    if (received_bytes_.size() < kCookieBytes) return true;
    if (!take_cookie()) return false;
  }
  std::span<const std::byte> unread(received_bytes_);
  while (true) {
    Message message;
    const ReadStatus status = read_message(unread, message, kMaxServerMessageBytes);
    if (status == ReadStatus::broken) return false;
    if (status == ReadStatus::incomplete) break;
    if (!receive_message(message)) return false;
  }
  received_bytes_.erase(received_bytes_.begin(), received_bytes_.end() - static_cast<std::ptrdiff_t>(unread.size()));
  return true;
}

bool TrackerClient::take_cookie() {
  if (!is_cookie_good(std::span(received_bytes_).first(kCookieBytes))) return false;
  received_bytes_.erase(received_bytes_.begin(), received_bytes_.begin() + kCookieBytes);
  is_connected_ = true;
  append_description(bytes_to_send_, kSenderDescription, kSender, device_, {}, ++sequence_);
  append_description(bytes_to_send_, kTypeDescription, kPingType, kPing, {}, ++sequence_);
  return true;
}

bool TrackerClient::receive_message(const Message& message) {
  switch (message.type) {
    case kSenderDescription:
      receive_sender(message);
      return true;
    case kTypeDescription:
      receive_type(message);
      return true;
    case kDisconnect:
      return false;
    default:
      if (tracker_id_ != message.sender) return true;
      if (position_type_ == message.type) receive_position(message);
      if (change_type_ == message.type || states_type_ == message.type) receive_buttons(message);
      return true;
  }
}

// A description carries the id that it defines in its field `sender`. The server may give an id a new meaning at any time.
void TrackerClient::receive_sender(const Message& message) {
  const std::string_view name = name_of(message);
  if (name == device_) {
    tracker_id_ = message.sender;
  } else if (tracker_id_ == message.sender) {
    tracker_id_.reset();
  }
  const std::string printable_name = printable(name);
  const bool is_known = std::find(devices_.begin(), devices_.end(), printable_name) != devices_.end();
  if (!printable_name.empty() && !is_known && devices_.size() < kMaxDevices) devices_.push_back(printable_name);
}

void TrackerClient::receive_type(const Message& message) {
  const std::pair<std::string_view, std::optional<std::int32_t>&> known_types[] = {
      {kPosition, position_type_}, {kButtonChange, change_type_}, {kButtonStates, states_type_}};
  for (const auto& [name, number] : known_types) {
    if (name_of(message) == name) {
      number = message.sender;
    } else if (number == message.sender) {
      number.reset();
    }
  }
}

void TrackerClient::receive_buttons(const Message& message) {
  if (states_type_ == message.type) {
    const std::optional<std::uint32_t> states = buttons_of(message);
    if (!states) return;
    buttons_ = *states;
    reported_buttons_ = ~std::uint32_t{0};
    return;
  }
  const std::optional<ButtonChange> change = button_of(message);
  if (!change || change->button < 0 || change->button >= 32) return;
  const std::uint32_t bit = std::uint32_t{1} << change->button;
  buttons_ = change->is_down ? buttons_ | bit : buttons_ & ~bit;
  reported_buttons_ |= bit;
}

void TrackerClient::receive_position(const Message& message) {
  const std::optional<SensorPose> pose = position_of(message);
  if (!pose || pose->sensor != sensor_ || !pose->p_m.allFinite()) return;
  const double length = pose->q.norm();
  if (!(length > kMinQuaternionNorm && length < kMaxQuaternionNorm)) return;  // rejects NaN as well
  newest_ = TrackerPose{pose->p_m, pose->q.normalized()};
}

std::optional<TrackerPose> TrackerClient::take_newest() { return std::exchange(newest_, std::nullopt); }

void TrackerClient::ping() { append_empty(bytes_to_send_, {kSender, kPingType, {}, ++sequence_}); }

std::string TrackerClient::describe_devices() const {
  std::string text;
  for (const std::string& device : devices_) text += (text.empty() ? "" : ", ") + device;
  return text;
}

}  // namespace hapton::vrpn
