#include "link/codec.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <variant>

#include "hapton.pb.h"
#include "link/endpoint.h"
#include "link/message_kinds.h"
#include "link/protobuf_codec.h"
#include "link/round_trip_codec.h"
#include "link/wire_fields.h"

namespace hapton {
namespace {

template <class Theirs, class Ours>
DecodeStatus read_into(const Theirs& from, Ours& to) {
  return read(from, to) ? DecodeStatus::ok : DecodeStatus::bad_value;
}

DecodeStatus read_into(const wire::ViewTransform& from, ViewTransform& to) {
  if (read(from, to)) return DecodeStatus::ok;
  const bool has_all_numbers = from.x_ws().size() == static_cast<int>(to.X_WS.size());
  to.X_WS = ViewTransform().X_WS;
  return has_all_numbers ? DecodeStatus::not_rigid : DecodeStatus::bad_value;
}

template <class Ours, class Theirs>
DecodeStatus read_message(const wire::Envelope& envelope, const Theirs& from, Datagram& datagram) {
  if (!is_wire_time(envelope.send_time_ns())) return DecodeStatus::bad_value;
  Ours message;
  const DecodeStatus status = read_into(from, message);
  if (status == DecodeStatus::bad_value) return status;
  datagram.header = {
      .session = envelope.session(), .sender = envelope.sender(), .sequence = envelope.sequence(), .send_time_ns = envelope.send_time_ns()};
  datagram.message = message;
  return status;
}

DecodeStatus read_any(const wire::Envelope& envelope, Datagram& datagram) {
  const int kinds = std::apply([&](const auto&... kind) { return (static_cast<int>((envelope.*kind.has)()) + ...); }, kMessageKinds);
  if (kinds > 1) return DecodeStatus::bad_value;
  DecodeStatus status = DecodeStatus::unknown_message;
  visit_kinds([&](const auto& kind) {
    if (!(envelope.*kind.has)()) return false;
    status = read_message<typename std::decay_t<decltype(kind)>::Ours>(envelope, (envelope.*kind.get)(), datagram);
    return true;
  });
  return status;
}

// The version comes first and keeps its position in every version, so it is read before anything that may have changed.
std::optional<std::uint64_t> peek_version(std::span<const std::byte> bytes) {
  constexpr std::byte kVersionTag{0x08};  // field 1, varint
  if (bytes.size() < 2 || bytes[0] != kVersionTag) {
    return std::nullopt;
  }
  std::uint64_t version = 0;
  for (std::size_t i = 1; i < std::min<std::size_t>(bytes.size(), 10); ++i) {
    version |= (std::to_integer<std::uint64_t>(bytes[i]) & 0x7FU) << (7 * (i - 1));
    if ((bytes[i] & std::byte{0x80}) == std::byte{0}) {
      return version;
    }
  }
  return std::nullopt;
}

// True: every field ends within the datagram. The parser checks this too, but only after it has reserved room for whatever length the
// message states.
bool is_well_framed(std::span<const std::byte> bytes) {
  using google::protobuf::internal::WireFormatLite;
  google::protobuf::io::CodedInputStream input(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
  while (const std::uint32_t tag = input.ReadTag()) {
    if (!WireFormatLite::SkipField(&input, tag)) {
      return false;
    }
  }
  return input.ConsumedEntireMessage();
}

// --- reserving: afterwards no datagram of at most kMaxDatagramBytes makes a message grow ---

template <class Field>
void reserve_field(Field& field) {
  field.Reserve(static_cast<int>(kMaxDatagramBytes / sizeof(*field.data())) + 1);
}

// The lite runtime keeps unknown fields in a string, which only parsing reaches: one long unknown field at start-up gives it its final
// capacity.
template <class WireMessage>
void reserve_unknown(WireMessage& message) {
  std::string unknown = "\xC2\x3E\x80\x10";  // field 1000, length-delimited, 2048 bytes
  unknown.append(2048, ' ');
  message.ParseFromString(unknown);
}

void reserve(wire::DeviceState& m) {
  reserve_field(*m.mutable_p_wd_m());
  reserve_field(*m.mutable_q_wt());
  reserve_field(*m.mutable_p_wp_m());
}
void reserve(wire::ForceCommand& m) {
  reserve_field(*m.mutable_force_n());
  reserve_field(*m.mutable_visual_offset_m());
  reserve_field(*m.mutable_torque_nm());
  reserve_field(*m.mutable_visual_turn());
  reserve_field(*m.mutable_push_force_n());
  reserve_field(*m.mutable_push_torque_nm());
  reserve_field(*m.mutable_held_offset_m());
}
void reserve(wire::ProbeState& m) {
  reserve_field(*m.mutable_p_wd_m());
  reserve_field(*m.mutable_q_wt());
  reserve_field(*m.mutable_visual_offset_m());
  reserve_field(*m.mutable_force_n());
  reserve_field(*m.mutable_torque_nm());
  reserve_field(*m.mutable_visual_turn());
  reserve_field(*m.mutable_push_force_n());
  reserve_field(*m.mutable_push_torque_nm());
}
void reserve(wire::ViewTransform& m) { reserve_field(*m.mutable_x_ws()); }
void reserve(wire::FrameAck&) {}
void reserve(wire::Hello&) {}
void reserve(wire::Welcome&) {}
void reserve(wire::HandTarget& m) {
  reserve_field(*m.mutable_p_wh_m());
  reserve_field(*m.mutable_turn_rad());
}
void reserve(wire::Settings& m) { m.mutable_method()->reserve(kMaxDatagramBytes); }
void reserve(wire::HapticsSetup& m) {
  reserve_field(*m.mutable_x_ws());
  m.mutable_scene()->reserve(kMaxDatagramBytes);
  m.mutable_build()->reserve(kMaxDatagramBytes);
  m.mutable_method()->reserve(kMaxDatagramBytes);
  m.mutable_rejection()->reserve(kMaxDatagramBytes);
}
void reserve(wire::SceneFacts& m) {
  reserve_field(*m.mutable_lowest_m());
  reserve_field(*m.mutable_highest_m());
  reserve_field(*m.mutable_points_m());
}
void reserve(wire::ReportRequest&) {}
void reserve(wire::ReportPart& m) { m.mutable_text()->reserve(kMaxDatagramBytes); }
void reserve(wire::ViewRejected&) {}
void reserve(wire::LoopFacts& m) { m.mutable_device()->reserve(kMaxDatagramBytes); }
void reserve(wire::PatchBegin& m) { reserve_field(*m.mutable_origin_m()); }
// A varint takes at least one byte, so a datagram contains at most this many.
void reserve(wire::PatchCell& m) {
  m.mutable_index()->Reserve(kMaxDatagramBytes);
  m.mutable_empty_children()->reserve(kMaxDatagramBytes);
  m.mutable_tiles()->Reserve(kMaxDatagramBytes);
}
void reserve(wire::PatchTile& m) {
  m.mutable_vertices()->reserve(kMaxDatagramBytes);
  m.mutable_triangles()->reserve(kMaxDatagramBytes);
}
void reserve(wire::PatchBody& m) {
  m.mutable_bounds()->Reserve(kMaxDatagramBytes);
  reserve_field(*m.mutable_pivot_m());
  reserve_field(*m.mutable_keys());
}
void reserve(wire::PatchDeformation& m) { reserve_field(*m.mutable_keys()); }
void reserve(wire::PatchDisplacements& m) { reserve_field(*m.mutable_by_m()); }
void reserve(wire::PatchStream& m) {
  reserve_field(*m.mutable_to_scene());
  m.mutable_vertices()->Reserve(kMaxDatagramBytes);
}
void reserve(wire::PatchEffects& m) { m.mutable_bytes()->reserve(kMaxDatagramBytes); }
void reserve(wire::PatchMaterial&) {}
void reserve(wire::PatchStatus& m) { m.mutable_received()->reserve(kMaxDatagramBytes); }
void reserve(wire::MaterialRequest& m) { m.mutable_object()->reserve(kMaxDatagramBytes); }
void reserve(wire::MaterialState& m) {
  m.mutable_rejection()->reserve(kMaxDatagramBytes);
  m.mutable_object()->Reserve(kMaxDatagramBytes);
  m.mutable_given()->Reserve(kMaxDatagramBytes);
  reserve_field(*m.mutable_numbers());
}
void reserve(wire::ObjectPose& m) {
  reserve_field(*m.mutable_p_m());
  reserve_field(*m.mutable_q());
}
void reserve(wire::Marker& m) { m.mutable_text()->reserve(kMaxDatagramBytes); }
void reserve(wire::MarkerReply&) {}
void reserve(wire::MoveRequest& m) {
  m.mutable_object()->reserve(kMaxDatagramBytes);
  reserve_field(*m.mutable_p_m());
  reserve_field(*m.mutable_q());
}
void reserve(wire::MoveReply& m) { m.mutable_rejection()->reserve(kMaxDatagramBytes); }
void reserve(wire::ObjectMove& m) {
  reserve_field(*m.mutable_from_p_m());
  reserve_field(*m.mutable_from_q());
  reserve_field(*m.mutable_to_p_m());
  reserve_field(*m.mutable_to_q());
  m.mutable_name()->reserve(kMaxDatagramBytes);
}
void reserve(wire::Carves& m) {
  m.mutable_object()->Reserve(kMaxDatagramBytes);
  reserve_field(*m.mutable_numbers());
  reserve_field(*m.mutable_undone());
}
void reserve(wire::CarveStatus&) {}
void reserve(wire::CarveUndo&) {}
void reserve(wire::ShapeRequest& m) {
  m.mutable_object()->reserve(kMaxDatagramBytes);
  m.mutable_displacements()->reserve(kMaxDatagramBytes);
}
void reserve(wire::ShapeReply& m) { m.mutable_rejection()->reserve(kMaxDatagramBytes); }
void reserve(wire::ObjectShape& m) { m.mutable_displacements()->reserve(kMaxDatagramBytes); }
void reserve(wire::ShapeStart&) {}
void reserve(wire::ShapeStatus&) {}
void reserve(wire::Bye&) {}

}  // namespace

// One Envelope for sending and one for receiving; each owns one message of every kind.
struct Codec::Wire {
  wire::Envelope outgoing;
  wire::Envelope incoming;

  Wire() {
    reserve_all(outgoing);
    reserve_all(incoming);
  }

  static void reserve_all(wire::Envelope& envelope) {
    reserve_unknown(envelope);
    visit_kinds([&](const auto& kind) {
      auto& message = *(envelope.*kind.make)();
      reserve_unknown(message);
      reserve(message);
      return false;
    });
    envelope.Clear();
  }
};

std::string_view to_string(DecodeStatus status) noexcept {
  switch (status) {
    case DecodeStatus::ok:
      return "ok";
    case DecodeStatus::truncated:
      return "truncated";
    case DecodeStatus::wrong_version:
      return "wrong version";
    case DecodeStatus::unknown_message:
      return "unknown message";
    case DecodeStatus::bad_value:
      return "bad value";
    case DecodeStatus::not_rigid:
      return "pose not rigid";
  }
  return "?";
}

Codec::Codec() : wire_(std::make_unique<Wire>()) {}
Codec::~Codec() = default;
Codec::Codec(Codec&&) noexcept = default;
Codec& Codec::operator=(Codec&&) noexcept = default;

std::size_t Codec::encode(const Datagram& datagram, std::span<std::byte> into) noexcept {
  if (const std::size_t bytes = encode_round_trip(datagram, into); bytes != 0) return bytes;
  wire::Envelope& envelope = wire_->outgoing;
  envelope.Clear();
  envelope.set_version(kProtocolVersion);
  envelope.set_session(datagram.header.session);
  envelope.set_sender(datagram.header.sender);
  envelope.set_sequence(datagram.header.sequence);
  envelope.set_send_time_ns(datagram.header.send_time_ns);
  visit_kinds([&](const auto& kind) {
    const auto* message = std::get_if<typename std::decay_t<decltype(kind)>::Ours>(&datagram.message);
    if (message != nullptr) write(*message, *(envelope.*kind.make)());
    return message != nullptr;
  });
  const std::size_t bytes = envelope.ByteSizeLong();
  if (bytes > into.size() || bytes > kMaxDatagramBytes) {
    return 0;
  }
  envelope.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(into.data()));
  return bytes;
}

DecodeStatus Codec::decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept {
  if (bytes.size() > kMaxDatagramBytes) {
    return DecodeStatus::bad_value;
  }
  if (decode_round_trip(bytes, datagram)) return DecodeStatus::ok;
  const std::optional<std::uint64_t> version = peek_version(bytes);
  if (!version) {
    return DecodeStatus::truncated;
  }
  if (*version != kProtocolVersion) {
    return DecodeStatus::wrong_version;
  }
  wire::Envelope& envelope = wire_->incoming;
  if (!is_well_framed(bytes) || !envelope.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return DecodeStatus::truncated;
  }
  if (envelope.version() != kProtocolVersion) {
    return DecodeStatus::wrong_version;
  }
  return read_any(envelope, datagram);
}

}  // namespace hapton
