#include "vrpn/vrpn_wire.h"

#include <algorithm>
#include <bit>
#include <initializer_list>

namespace hapton::vrpn {
namespace {

constexpr std::string_view kCookie = "vrpn: ver. 07.38  0";
constexpr std::string_view kUnderstood = "vrpn: ver. 07.";
constexpr std::size_t kLongestName = 100;  // the size of a vrpn_CNAME

template <class Unsigned>
void put(Bytes& out, Unsigned value) {
  for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8) out.push_back(static_cast<std::byte>(value >> shift));
}
void put_int(Bytes& out, std::int32_t value) { put(out, static_cast<std::uint32_t>(value)); }
void put_double(Bytes& out, double value) { put(out, std::bit_cast<std::uint64_t>(value)); }
void put_vector(Bytes& out, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) put_double(out, v[axis]);
}
void put_quat(Bytes& out, const Quat& q) {
  for (const double part : {q.x(), q.y(), q.z(), q.w()}) put_double(out, part);
}
void put_text(Bytes& out, std::string_view text) {
  for (const char letter : text) out.push_back(static_cast<std::byte>(letter));
}

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = (value << 8) | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

double read_double(std::span<const std::byte> bytes, std::size_t at) {
  return std::bit_cast<double>(std::uint64_t{read_u32(bytes, at)} << 32 | read_u32(bytes, at + 4));
}

std::size_t padded(std::size_t bytes) { return (bytes + kPadding - 1) / kPadding * kPadding; }

// Writes one message: first the header; at the end the padding of the body, and the length, which counts header and body without padding.
class MessageWriter {
 public:
  MessageWriter(Bytes& out, const Header& header) : out_(out), start_(out.size()) {
    put(out, std::uint32_t{0});
    put(out, header.time.s);
    put(out, header.time.us);
    put_int(out, header.sender);
    put_int(out, header.type);
    put(out, header.sequence);
  }
  ~MessageWriter() {
    const auto length = static_cast<std::uint32_t>(out_.size() - start_);
    for (std::size_t i = 0; i < 4; ++i) out_[start_ + i] = static_cast<std::byte>(length >> (24 - 8 * i));
    out_.resize(start_ + padded(length));
  }
  MessageWriter(const MessageWriter&) = delete;
  MessageWriter& operator=(const MessageWriter&) = delete;

 private:
  Bytes& out_;
  std::size_t start_;
};

constexpr std::int32_t kSensor = 0;

}  // namespace

void append_cookie(Bytes& out) {
  put_text(out, kCookie);
  out.resize(out.size() + kCookieBytes - kCookie.size());
}

bool is_cookie_good(std::span<const std::byte> cookie) {
  return std::equal(kUnderstood.begin(), kUnderstood.end(), cookie.begin(),
                    [](char letter, std::byte byte) { return static_cast<std::byte>(letter) == byte; });
}

void append_description(Bytes& out, std::int32_t kind, std::int32_t id, std::string_view name, Time time, std::uint32_t sequence) {
  const MessageWriter writer(out, {id, kind, time, sequence});
  put(out, static_cast<std::uint32_t>(name.size() + 1));
  put_text(out, name);
  out.push_back(std::byte{0});
}

void append_position(Bytes& out, const Header& header, std::int32_t sensor, const Vec3& p_m, const Quat& q) {
  const MessageWriter writer(out, header);
  put_int(out, sensor);
  put_int(out, sensor);  // padding: the numbers that follow are then aligned
  put_vector(out, p_m);
  put_quat(out, q);
}

void append_velocity(Bytes& out, const Header& header, const Vec3& v_m_per_s, const Quat& turn, double dt_s) {
  const MessageWriter writer(out, header);
  put_int(out, kSensor);
  put_int(out, kSensor);
  put_vector(out, v_m_per_s);
  put_quat(out, turn);
  put_double(out, dt_s);
}

void append_workspace(Bytes& out, const Header& header, const Vec3& low_m, const Vec3& high_m) {
  const MessageWriter writer(out, header);
  put_vector(out, low_m);
  put_vector(out, high_m);
}

void append_button_change(Bytes& out, const Header& header, std::int32_t button, bool is_down) {
  const MessageWriter writer(out, header);
  put_int(out, button);
  put_int(out, is_down ? 1 : 0);
}

void append_button_states(Bytes& out, const Header& header, std::uint32_t buttons, std::int32_t count) {
  const MessageWriter writer(out, header);
  put_int(out, count);
  for (std::int32_t n = 0; n < count; ++n) put_int(out, static_cast<std::int32_t>((buttons >> n) & 1U));
}

void append_analog(Bytes& out, const Header& header, std::span<const double> channels) {
  const MessageWriter writer(out, header);
  put_double(out, static_cast<double>(channels.size()));
  for (const double value : channels) put_double(out, value);
}

void append_force(Bytes& out, const Header& header, const Vec3& force_n) {
  const MessageWriter writer(out, header);
  put_vector(out, force_n);
}

void append_force_error(Bytes& out, const Header& header, std::int32_t error) {
  const MessageWriter writer(out, header);
  put_int(out, error);
}

void append_to_room(Bytes& out, const Header& header) {
  const MessageWriter writer(out, header);
  put_vector(out, Vec3::Zero());
  put_quat(out, Quat::Identity());
}

void append_unit_to_sensor(Bytes& out, const Header& header, std::int32_t sensor) {
  const MessageWriter writer(out, header);
  put_int(out, sensor);
  put_int(out, 0);
  put_vector(out, Vec3::Zero());
  put_quat(out, Quat::Identity());
}

void append_contact_point(Bytes& out, const Header& header, const Vec3& p_m, const Quat& q, bool is_contact) {
  const MessageWriter writer(out, header);
  put_vector(out, is_contact ? p_m : Vec3(Vec3::Zero()));
  put_quat(out, is_contact ? q : Quat(0.0, 0.0, 0.0, 0.0));
}

// The body has a fixed size: VRPN's clients read all of it, whatever the text's length.
void append_error_text(Bytes& out, const Header& header, std::string_view text) {
  constexpr std::size_t kTextBytes = 1024;
  constexpr std::int32_t kError = 2, kLevel = 0;
  const MessageWriter writer(out, header);
  put_int(out, kError);
  put_int(out, kLevel);
  const std::size_t begin = out.size();
  put_text(out, text.substr(0, kTextBytes - 1));
  out.resize(begin + kTextBytes);
}

void append_empty(Bytes& out, const Header& header) { const MessageWriter writer(out, header); }

ReadStatus read_message(std::span<const std::byte>& bytes, Message& into, std::size_t most_bytes) {
  if (bytes.size() < kHeaderBytes) return ReadStatus::incomplete;
  const std::size_t length = read_u32(bytes, 0);
  if (length < kHeaderBytes || length > most_bytes) return ReadStatus::broken;
  if (bytes.size() < padded(length)) return ReadStatus::incomplete;
  into.sender = static_cast<std::int32_t>(read_u32(bytes, 12));
  into.type = static_cast<std::int32_t>(read_u32(bytes, 16));
  into.body = bytes.subspan(kHeaderBytes, length - kHeaderBytes);
  bytes = bytes.subspan(padded(length));
  return ReadStatus::message;
}

std::optional<double> number_of(const Message& message) {
  if (message.body.size() != sizeof(double)) return std::nullopt;
  return read_double(message.body, 0);
}

std::optional<SensorPose> position_of(const Message& message) {
  constexpr std::size_t kBytes = 64, kPosition = 8, kTurn = 32;
  if (message.body.size() != kBytes) return std::nullopt;
  const auto number = [&](std::size_t from, std::size_t n) { return read_double(message.body, from + sizeof(double) * n); };
  SensorPose pose;
  pose.sensor = static_cast<std::int32_t>(read_u32(message.body, 0));
  pose.p_m = Vec3(number(kPosition, 0), number(kPosition, 1), number(kPosition, 2));
  pose.q = Quat(number(kTurn, 3), number(kTurn, 0), number(kTurn, 1), number(kTurn, 2));
  return pose;
}

std::optional<ButtonChange> button_of(const Message& message) {
  if (message.body.size() != 2 * sizeof(std::uint32_t)) return std::nullopt;
  return ButtonChange{static_cast<std::int32_t>(read_u32(message.body, 0)), read_u32(message.body, sizeof(std::uint32_t)) != 0};
}

std::optional<std::uint32_t> buttons_of(const Message& message) {
  constexpr std::size_t kWord = sizeof(std::uint32_t);
  if (message.body.size() < kWord) return std::nullopt;
  const std::size_t count = read_u32(message.body, 0);
  if (message.body.size() != kWord * (1 + count)) return std::nullopt;
  std::uint32_t buttons = 0;
  for (std::size_t n = 0; n < std::min<std::size_t>(count, 32); ++n) {
    if (read_u32(message.body, kWord * (1 + n)) != 0) buttons |= std::uint32_t{1} << n;
  }
  return buttons;
}

std::string_view name_of(const Message& description) {
  constexpr std::size_t kPrefix = 4;
  const std::span<const std::byte> body = description.body;
  if (body.size() <= kPrefix) return {};
  const std::size_t size = read_u32(body, 0);
  if (size == 0 || size > body.size() - kPrefix || size > kLongestName) return {};
  if (body[kPrefix + size - 1] != std::byte{0}) return {};
  return {reinterpret_cast<const char*>(body.data()) + kPrefix, size - 1};
}

}  // namespace hapton::vrpn
