#include "link/round_trip_codec.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <variant>

#include "link/codec.h"
#include "link/endpoint.h"
#include "link/wire_fields.h"

namespace hapton {
namespace {

enum class WireType : std::uint32_t { varint = 0, fixed64 = 1, length_delimited = 2, fixed32 = 5 };

constexpr std::uint32_t kDeviceStateField = 19;
constexpr std::uint32_t kForceCommandField = 20;
constexpr std::uint32_t kVersionField = 1;

template <class Number>
constexpr WireType kTypeOf = sizeof(Number) == 8 ? WireType::fixed64 : WireType::fixed32;

// A number below 2^14, of one or two bytes: tags, lengths, the version.
struct Varint {
  explicit constexpr Varint(std::size_t value)
      : bytes{static_cast<std::uint8_t>(value < 0x80 ? value : (value & 0x7F) | 0x80), static_cast<std::uint8_t>(value >> 7)},
        size(value < 0x80 ? 1 : 2) {}
  std::uint8_t bytes[2];
  std::size_t size;
};
constexpr Varint tag_of(std::uint32_t field, WireType type) { return Varint(field << 3 | static_cast<std::uint32_t>(type)); }

// The three classes below visit the same layout: they compute its size, write a message, and read a message.

class FixedSize {
 public:
  static constexpr bool kReads = false;
  template <class Number>
  void number(std::uint32_t field, const Number&) {
    size_ += tag_of(field, kTypeOf<Number>).size + sizeof(Number);
  }
  void flag(std::uint32_t field, const bool&) { size_ += tag_of(field, WireType::varint).size + 1; }
  template <std::size_t N>
  void doubles(std::uint32_t field, const std::array<double, N>&) {
    size_ += tag_of(field, WireType::length_delimited).size + 1 + sizeof(double) * N;
  }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

// Pre: there is room for the whole layout at `at`.
class FixedWriter {
 public:
  static constexpr bool kReads = false;
  explicit FixedWriter(std::byte* at) : at_(at) {}
  void varint(std::size_t value) {
    const Varint number(value);
    put(number.bytes, number.size);
  }
  void tag(std::uint32_t field, WireType type) {
    const Varint number = tag_of(field, type);
    put(number.bytes, number.size);
  }
  template <class Number>
  void number(std::uint32_t field, const Number& value) {
    tag(field, kTypeOf<Number>);
    put(&value, sizeof(value));
  }
  void flag(std::uint32_t field, const bool& value) {
    tag(field, WireType::varint);
    varint(value ? 1 : 0);
  }
  template <std::size_t N>
  void doubles(std::uint32_t field, const std::array<double, N>& values) {
    tag(field, WireType::length_delimited);
    varint(sizeof(values));
    put(values.data(), sizeof(values));
  }

 private:
  void put(const void* from, std::size_t size) {
    std::memcpy(at_, from, size);
    at_ += size;
  }
  std::byte* at_;
};

// Reads nothing more after the first byte that is not as expected.
class FixedReader {
 public:
  static constexpr bool kReads = true;
  explicit FixedReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  bool is_good() const { return is_good_; }
  bool is_at_end() const { return bytes_.empty(); }
  std::size_t left() const { return bytes_.size(); }
  bool is_next(std::uint32_t field, WireType type) const {
    const Varint number = tag_of(field, type);
    return bytes_.size() >= number.size && std::memcmp(bytes_.data(), number.bytes, number.size) == 0;
  }
  void expect(const Varint& number) {
    is_good_ = is_good_ && bytes_.size() >= number.size && std::memcmp(bytes_.data(), number.bytes, number.size) == 0;
    if (is_good_) bytes_ = bytes_.subspan(number.size);
  }
  template <class Number>
  void number(std::uint32_t field, Number& value) {
    expect(tag_of(field, kTypeOf<Number>));
    take(&value, sizeof(value));
  }
  void flag(std::uint32_t field, bool& value) {
    expect(tag_of(field, WireType::varint));
    std::uint8_t byte = 0;
    take(&byte, 1);
    is_good_ = is_good_ && byte <= 1;
    value = byte == 1;
  }
  template <std::size_t N>
  void doubles(std::uint32_t field, std::array<double, N>& values) {
    expect(tag_of(field, WireType::length_delimited));
    expect(Varint(sizeof(values)));
    take(values.data(), sizeof(values));
  }
  void require(bool is_valid) { is_good_ = is_good_ && is_valid; }

 private:
  void take(void* to, std::size_t size) {
    is_good_ = is_good_ && bytes_.size() >= size;
    if (!is_good_) return;
    std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  std::span<const std::byte> bytes_;
  bool is_good_ = true;
};

template <class Wire, class Time>
void lay_out_time(Wire& wire, std::uint32_t field, Time& time_ns) {
  wire.number(field, time_ns);
  if constexpr (Wire::kReads) wire.require(is_wire_time(time_ns));
}

template <class Wire, class Vector>
void lay_out_vector(Wire& wire, std::uint32_t field, Vector& v) {
  std::array<double, 3> values{v[0], v[1], v[2]};
  wire.doubles(field, values);
  if constexpr (Wire::kReads) {
    v = Vec3(values[0], values[1], values[2]);
    wire.require(is_wire_vector(v));
  }
}

template <class Wire, class Rotation>
void lay_out_rotation(Wire& wire, std::uint32_t field, Rotation& q) {
  std::array<double, 4> values{q.w(), q.x(), q.y(), q.z()};
  wire.doubles(field, values);
  if constexpr (Wire::kReads) {
    q = Quat(values[0], values[1], values[2], values[3]);
    wire.require(is_wire_rotation(q));
  }
}

// --- the layouts, as in proto/hapton.proto ---

template <class Wire, class Time>
void lay_out_scene_time(Wire& wire, Time& time_ns) {
  constexpr std::uint32_t kField = 8;
  if constexpr (Wire::kReads) {
    time_ns = -1;
    if (wire.is_at_end()) return;
    lay_out_time(wire, kField, time_ns);
    wire.require(time_ns >= 0);
  } else {
    if (time_ns >= 0) wire.number(kField, time_ns);
  }
}

template <class Wire, class Message>
void lay_out_device_state(Wire& wire, Message& m) {
  wire.number(1, m.sample);
  lay_out_time(wire, 2, m.sample_time_ns);
  lay_out_vector(wire, 3, m.p_WD);
  lay_out_rotation(wire, 4, m.q_WT);
  wire.number(5, m.buttons);
  lay_out_vector(wire, 6, m.p_WP);
  wire.flag(7, m.is_resumed);
  lay_out_scene_time(wire, m.scene_time_ns);
}

template <class Wire, class Object>
void lay_out_touched(Wire& wire, Object& object) {
  std::uint32_t touched = write_object(object);
  wire.number(12, touched);
  if constexpr (Wire::kReads) object = read_object(touched);
}

template <class Wire, class Push>
void lay_out_push(Wire& wire, Push& push) {
  constexpr std::uint32_t kForceField = 18;
  if constexpr (Wire::kReads) {
    push.reset();
    if (!wire.is_next(kForceField, WireType::length_delimited)) return;
    push.emplace();
  }
  if (!push) return;
  lay_out_vector(wire, kForceField, push->force_n);
  lay_out_vector(wire, 19, push->torque_nm);
}

template <class Wire, class Haptons>
void lay_out_haptons(Wire& wire, Haptons& haptons) {
  constexpr std::uint32_t kField = 21;
  if constexpr (Wire::kReads) {
    haptons.reset();
    if (!wire.is_next(kField, WireType::fixed32)) return;
    haptons.emplace();
  }
  if (haptons) wire.number(kField, *haptons);
}

template <class Wire, class Offset>
void lay_out_held_offset(Wire& wire, Offset& offset_m) {
  constexpr std::uint32_t kField = 22;
  if constexpr (Wire::kReads) {
    offset_m.reset();
    if (!wire.is_next(kField, WireType::length_delimited)) return;
    offset_m.emplace();
  }
  if (offset_m) lay_out_vector(wire, kField, *offset_m);
}

template <class Wire, class Message>
void lay_out_force_command(Wire& wire, Message& message) {
  wire.number(1, message.echo_sample);
  lay_out_time(wire, 2, message.echo_sample_time_ns);
  lay_out_vector(wire, 3, message.force_n);
  lay_out_vector(wire, 4, message.visual_offset_m);
  wire.flag(5, message.contact);
  wire.number(6, message.compute_ns);
  wire.number(7, message.skipped_samples);
  wire.number(8, message.view_revision);
  wire.number(9, message.method_serial);
  wire.number(10, message.replied_before);
  wire.number(11, message.material_serial);
  lay_out_touched(wire, message.object);
  lay_out_vector(wire, 13, message.torque_nm);
  lay_out_vector(wire, 14, message.visual_turn);
  lay_out_time(wire, 15, message.scene_time_ns);
  wire.number(16, message.move_serial);
  wire.number(17, message.carve_serial);
  lay_out_push(wire, message.push);
  wire.number(20, message.shape_serial);
  lay_out_haptons(wire, message.haptons);
  lay_out_held_offset(wire, message.held_offset_m);
}

template <class Wire, class Message>
void lay_out(Wire& wire, Message& m) {
  if constexpr (std::is_same_v<std::remove_const_t<Message>, DeviceState>) {
    lay_out_device_state(wire, m);
  } else {
    lay_out_force_command(wire, m);
  }
}

template <class Wire, class Fields>
void lay_out_header(Wire& wire, Fields& header) {
  wire.number(2, header.session);
  wire.number(3, header.sender);
  wire.number(4, header.sequence);
  lay_out_time(wire, 5, header.send_time_ns);
}

template <class Message>
std::size_t encode_as(std::uint32_t field, const Header& header, const Message& message, std::span<std::byte> into) {
  FixedSize content;
  lay_out(content, message);
  FixedSize head;
  lay_out_header(head, header);
  const std::size_t size = tag_of(kVersionField, WireType::varint).size + Varint(kProtocolVersion).size + head.size() +
                           tag_of(field, WireType::length_delimited).size + Varint(content.size()).size + content.size();
  if (size > into.size() || size > kMaxDatagramBytes) return 0;
  FixedWriter writer(into.data());
  writer.tag(kVersionField, WireType::varint);
  writer.varint(kProtocolVersion);
  lay_out_header(writer, header);
  writer.tag(field, WireType::length_delimited);
  writer.varint(content.size());
  lay_out(writer, message);
  return size;
}

// Pre: the reader has read the header.
template <class Message>
bool decode_as(std::uint32_t field, FixedReader& reader, const Header& header, Datagram& datagram) {
  reader.expect(tag_of(field, WireType::length_delimited));
  if (!reader.is_good() || reader.left() < 2) return false;
  // The length must be that of all bytes after it.
  const std::size_t left = reader.left();
  reader.expect(Varint(left - (left - 1 < 0x80 ? 1 : 2)));
  Message message;
  lay_out(reader, message);
  if (!reader.is_good() || !reader.is_at_end()) return false;
  datagram.header = header;
  datagram.message = message;
  return true;
}

constexpr bool kIsLittleEndian = std::endian::native == std::endian::little;

}  // namespace

std::size_t encode_round_trip(const Datagram& datagram, std::span<std::byte> into) noexcept {
  if constexpr (!kIsLittleEndian) return 0;
  if (const auto* state = std::get_if<DeviceState>(&datagram.message)) return encode_as(kDeviceStateField, datagram.header, *state, into);
  if (const auto* command = std::get_if<ForceCommand>(&datagram.message)) {
    return encode_as(kForceCommandField, datagram.header, *command, into);
  }
  return 0;
}

bool decode_round_trip(std::span<const std::byte> bytes, Datagram& datagram) noexcept {
  if constexpr (!kIsLittleEndian) return false;
  FixedReader reader(bytes);
  reader.expect(tag_of(kVersionField, WireType::varint));
  reader.expect(Varint(kProtocolVersion));
  Header header;
  lay_out_header(reader, header);
  if (!reader.is_good()) return false;
  if (reader.is_next(kDeviceStateField, WireType::length_delimited)) {
    return decode_as<DeviceState>(kDeviceStateField, reader, header, datagram);
  }
  if (reader.is_next(kForceCommandField, WireType::length_delimited)) {
    return decode_as<ForceCommand>(kForceCommandField, reader, header, datagram);
  }
  return false;
}

}  // namespace hapton
