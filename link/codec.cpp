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

namespace hapton {
namespace {

constexpr double kUnitTolerance = 1e-3;

// --- writing ---

template <class Field>
void write_vector(Field& field, const Vec3& v) {
  field.Clear();
  for (int i = 0; i < 3; ++i) {
    field.AddAlreadyReserved(v[i]);
  }
}

template <class Field>
void write_rotation(Field& field, const Quat& q) {
  field.Clear();
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) {
    field.AddAlreadyReserved(value);
  }
}

void write(const Hello& from, wire::Hello& to) { to.set_role(static_cast<wire::Role>(from.role)); }

void write(const Welcome& from, wire::Welcome& to) {
  to.set_accepted(from.accepted);
  to.set_servo_rate_hz(from.servo_rate_hz);
}

void write(const Bye&, wire::Bye&) {}

void write(const DeviceState& from, wire::DeviceState& to) {
  to.set_sample(from.sample);
  to.set_sample_time_ns(from.sample_time_ns);
  write_vector(*to.mutable_p_wd_m(), from.p_WD);
  write_rotation(*to.mutable_q_wt(), from.q_WT);
  to.set_buttons(from.buttons);
  to.set_is_resumed(from.is_resumed);
  write_vector(*to.mutable_p_wp_m(), from.p_WP);
}

void write(const ForceCommand& from, wire::ForceCommand& to) {
  to.set_echo_sample(from.echo_sample);
  to.set_echo_sample_time_ns(from.echo_sample_time_ns);
  write_vector(*to.mutable_force_n(), from.force_n);
  write_vector(*to.mutable_visual_offset_m(), from.visual_offset_m);
  to.set_contact(from.contact);
  to.set_compute_ns(from.compute_ns);
  to.set_skipped_samples(from.skipped_samples);
  to.set_view_revision(from.view_revision);
  to.set_method_serial(from.method_serial);
  to.set_answered_before(from.answered_before);
}

void write(const ViewTransform& from, wire::ViewTransform& to) {
  to.set_revision(from.revision);
  to.mutable_x_ws()->Clear();
  for (const float value : from.X_WS) {
    to.mutable_x_ws()->AddAlreadyReserved(value);
  }
}

void write(const ProbeState& from, wire::ProbeState& to) {
  to.set_sample(from.sample);
  to.set_sample_time_ns(from.sample_time_ns);
  write_vector(*to.mutable_p_wd_m(), from.p_WD);
  write_rotation(*to.mutable_q_wt(), from.q_WT);
  write_vector(*to.mutable_visual_offset_m(), from.visual_offset_m);
  write_vector(*to.mutable_force_n(), from.force_n);
  to.set_contact(from.contact);
  to.set_buttons(from.buttons);
  to.set_servo_rate_hz(from.servo_rate_hz);
  to.set_round_trip_p50_us(from.round_trip_p50_us);
  to.set_round_trip_p99_us(from.round_trip_p99_us);
  to.set_view_revision(from.view_revision);
  to.set_status(static_cast<std::uint32_t>(from.status));
}

void write(const Drawn& from, wire::Drawn& to) {
  to.set_echo_sample(from.echo_sample);
  to.set_echo_sample_time_ns(from.echo_sample_time_ns);
  to.set_frame_rate_hz(from.frame_rate_hz);
  to.set_held_ns(from.held_ns);
  to.set_rest_ns(from.rest_ns);
  to.set_unchanged(from.unchanged);
}

void write(const HandTarget& from, wire::HandTarget& to) {
  to.set_active(from.active);
  write_vector(*to.mutable_p_wh_m(), from.p_WH);
}

void write(const Settings& from, wire::Settings& to) {
  to.set_servo_rate_hz(from.servo_rate_hz);
  const auto* end = std::find(from.method.data(), from.method.data() + from.method.size(), '\0');
  to.mutable_method()->assign(from.method.data(), static_cast<std::size_t>(end - from.method.data()));
  to.set_report_now(from.report_now);
  to.set_reset_faults(from.reset_faults);
  to.set_method_ask(from.method_ask);
}

template <std::size_t N>
void write_text(const std::array<char, N>& from, std::string& to) {
  to.assign(from.data(), static_cast<std::size_t>(std::find(from.begin(), from.end(), '\0') - from.begin()));
}

void write(const HapticsSetup& from, wire::HapticsSetup& to) {
  to.set_method_serial(from.method_serial);
  to.set_view_revision(from.view_revision);
  to.mutable_x_ws()->Clear();
  for (const float value : from.X_WS) {
    to.mutable_x_ws()->AddAlreadyReserved(value);
  }
  to.set_scene_hash(from.scene_hash);
  write_text(from.scene, *to.mutable_scene());
  write_text(from.build, *to.mutable_build());
  write_text(from.method, *to.mutable_method());
  to.set_scene_loading(from.scene_loading);
  to.set_method_ask(from.method_ask);
  write_text(from.refusal, *to.mutable_refusal());
}

template <class Field>
void add_point(Field& field, const SceneFacts::Point& point) {
  for (const float value : point) field.AddAlreadyReserved(value);
}

void write(const SceneFacts& from, wire::SceneFacts& to) {
  to.set_given_hash(from.given_hash);
  to.mutable_lowest_m()->Clear();
  to.mutable_highest_m()->Clear();
  to.mutable_points_m()->Clear();
  add_point(*to.mutable_lowest_m(), from.lowest_m);
  add_point(*to.mutable_highest_m(), from.highest_m);
  for (std::size_t i = 0; i < std::min<std::size_t>(from.point_count, from.points_m.size()); ++i) {
    add_point(*to.mutable_points_m(), from.points_m[i]);
  }
}

void write(const ReportAsk& from, wire::ReportAsk& to) {
  to.set_document(static_cast<std::uint32_t>(from.document));
  to.set_revision(from.revision);
  to.set_part(from.part);
}

void write(const ReportPart& from, wire::ReportPart& to) {
  to.set_document(static_cast<std::uint32_t>(from.document));
  to.set_revision(from.revision);
  to.set_part(from.part);
  to.set_parts(from.parts);
  to.mutable_text()->assign(from.text.data(), std::min<std::size_t>(from.size, from.text.size()));
}

// --- reading: false for a value the contract rules out ---

bool is_rate(double value) { return std::isfinite(value) && value >= 0.0 && value <= kMaxWireMagnitude; }

template <class Field>
bool read_vector(const Field& field, Vec3& v) {
  if (field.size() != 3) {
    return false;
  }
  v = Vec3(field.Get(0), field.Get(1), field.Get(2));
  return v.allFinite() && v.cwiseAbs().maxCoeff() <= kMaxWireMagnitude;
}

template <class Field>
bool read_rotation(const Field& field, Quat& q) {
  if (field.size() != 4) {
    return false;
  }
  q = Quat(field.Get(0), field.Get(1), field.Get(2), field.Get(3));
  return std::abs(q.norm() - 1.0) <= kUnitTolerance;  // false for NaN as well
}

bool read(const wire::Hello& from, Hello& to) {
  to.role = static_cast<NodeRole>(from.role());
  return from.role() >= wire::ROLE_IO && from.role() <= wire::ROLE_TOOL;
}

bool read(const wire::Welcome& from, Welcome& to) {
  to.accepted = from.accepted();
  to.servo_rate_hz = from.servo_rate_hz();
  return is_rate(to.servo_rate_hz);
}

bool read(const wire::Bye&, Bye&) { return true; }

bool read(const wire::DeviceState& from, DeviceState& to) {
  to.sample = from.sample();
  to.sample_time_ns = from.sample_time_ns();
  to.buttons = from.buttons();
  to.is_resumed = from.is_resumed();
  return read_vector(from.p_wd_m(), to.p_WD) && read_rotation(from.q_wt(), to.q_WT) && read_vector(from.p_wp_m(), to.p_WP);
}

bool read(const wire::ForceCommand& from, ForceCommand& to) {
  to.echo_sample = from.echo_sample();
  to.echo_sample_time_ns = from.echo_sample_time_ns();
  to.contact = from.contact();
  to.compute_ns = from.compute_ns();
  to.skipped_samples = from.skipped_samples();
  to.view_revision = from.view_revision();
  to.method_serial = from.method_serial();
  to.answered_before = from.answered_before();
  return read_vector(from.force_n(), to.force_n) && read_vector(from.visual_offset_m(), to.visual_offset_m);
}

bool is_rigid(const std::array<float, 12>& X) {
  const Eigen::Matrix<double, 3, 4> pose = Eigen::Map<const Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>(X.data()).cast<double>();
  const Mat3 R = pose.leftCols<3>();
  const Vec3 t = pose.col(3);
  // Written so that NaN fails.
  return t.allFinite() && t.cwiseAbs().maxCoeff() <= kMaxWireMagnitude &&
         (R * R.transpose() - Mat3::Identity()).cwiseAbs().sum() <= kUnitTolerance && R.determinant() > 0.0;
}

template <class Field>
bool read_pose(const Field& field, std::array<float, 12>& X) {
  if (field.size() != static_cast<int>(X.size())) {
    return false;
  }
  std::copy(field.begin(), field.end(), X.begin());
  return is_rigid(X);
}

bool read(const wire::ViewTransform& from, ViewTransform& to) {
  to.revision = from.revision();
  return read_pose(from.x_ws(), to.X_WS);
}

bool read(const wire::ProbeState& from, ProbeState& to) {
  to.sample = from.sample();
  to.sample_time_ns = from.sample_time_ns();
  to.contact = from.contact();
  to.buttons = from.buttons();
  to.servo_rate_hz = from.servo_rate_hz();
  to.round_trip_p50_us = from.round_trip_p50_us();
  to.round_trip_p99_us = from.round_trip_p99_us();
  to.view_revision = from.view_revision();
  // What a newer hub may say is no reason to show nothing.
  to.status =
      from.status() <= static_cast<std::uint32_t>(ProbeStatus::too_small) ? static_cast<ProbeStatus>(from.status()) : ProbeStatus::ok;
  return read_vector(from.p_wd_m(), to.p_WD) && read_rotation(from.q_wt(), to.q_WT) &&
         read_vector(from.visual_offset_m(), to.visual_offset_m) && read_vector(from.force_n(), to.force_n) && is_rate(to.servo_rate_hz) &&
         is_rate(to.round_trip_p50_us) && is_rate(to.round_trip_p99_us);
}

bool read(const wire::Drawn& from, Drawn& to) {
  to.echo_sample = from.echo_sample();
  to.echo_sample_time_ns = from.echo_sample_time_ns();
  to.frame_rate_hz = from.frame_rate_hz();
  to.held_ns = from.held_ns();
  to.rest_ns = from.rest_ns();
  to.unchanged = from.unchanged();
  return is_rate(to.frame_rate_hz);
}

bool read(const wire::HandTarget& from, HandTarget& to) {
  to.active = from.active();
  return read_vector(from.p_wh_m(), to.p_WH);
}

bool read(const wire::Settings& from, Settings& to) {
  to.servo_rate_hz = from.servo_rate_hz();
  to.report_now = from.report_now();
  to.reset_faults = from.reset_faults();
  to.method_ask = from.method_ask();
  const std::string& method = from.method();
  if (method.size() > to.method.size() || !std::all_of(method.begin(), method.end(), [](char c) { return c > ' ' && c < '\x7f'; })) {
    return false;
  }
  to.method = {};
  std::copy(method.begin(), method.end(), to.method.begin());
  return to.servo_rate_hz == 0.0 || (to.servo_rate_hz >= kMinServoRateHz && to.servo_rate_hz <= kMaxServoRateHz);
}

// The last place stays NUL.
template <std::size_t N>
bool read_text(const std::string& from, std::array<char, N>& to) {
  if (from.size() >= N ||
      std::any_of(from.begin(), from.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; })) {
    return false;
  }
  to = {};
  std::copy(from.begin(), from.end(), to.begin());
  return true;
}

bool read(const wire::HapticsSetup& from, HapticsSetup& to) {
  to.method_serial = from.method_serial();
  to.view_revision = from.view_revision();
  to.scene_hash = from.scene_hash();
  to.method_ask = from.method_ask();
  to.scene_loading = from.scene_loading();
  return read_pose(from.x_ws(), to.X_WS) && read_text(from.scene(), to.scene) && read_text(from.build(), to.build) &&
         read_text(from.method(), to.method) && read_text(from.refusal(), to.refusal);
}

template <class Field>
bool read_point(const Field& field, int first, SceneFacts::Point& point) {
  for (std::size_t axis = 0; axis < point.size(); ++axis) {
    point[axis] = field.Get(first + static_cast<int>(axis));
    if (!(std::abs(point[axis]) <= static_cast<float>(kMaxWireMagnitude))) return false;
  }
  return true;
}

bool read(const wire::SceneFacts& from, SceneFacts& to) {
  to.given_hash = from.given_hash();
  const int numbers = from.points_m_size();
  if (from.lowest_m_size() != 3 || from.highest_m_size() != 3 || numbers % 3 != 0 || numbers > 3 * static_cast<int>(to.points_m.size())) {
    return false;
  }
  to.point_count = static_cast<std::uint32_t>(numbers / 3);
  for (int i = 0; i < numbers / 3; ++i) {
    if (!read_point(from.points_m(), 3 * i, to.points_m[static_cast<std::size_t>(i)])) return false;
  }
  return read_point(from.lowest_m(), 0, to.lowest_m) && read_point(from.highest_m(), 0, to.highest_m);
}

bool read_document(std::uint32_t from, ReportDocument& to) {
  to = static_cast<ReportDocument>(from);
  return from <= static_cast<std::uint32_t>(ReportDocument::csv);
}

bool read(const wire::ReportAsk& from, ReportAsk& to) {
  to.revision = from.revision();
  to.part = from.part();
  return read_document(from.document(), to.document);
}

bool read(const wire::ReportPart& from, ReportPart& to) {
  to.revision = from.revision();
  to.part = from.part();
  to.parts = from.parts();
  const std::string& text = from.text();
  if (text.size() > to.text.size() || to.part >= to.parts) {
    return false;
  }
  to.size = static_cast<std::uint16_t>(text.size());
  std::copy(text.begin(), text.end(), to.text.begin());
  return read_document(from.document(), to.document);
}

template <class Ours, class Theirs>
DecodeStatus read_message(const wire::Envelope& envelope, const Theirs& from, Datagram& datagram) {
  Ours message;
  if (!read(from, message)) {
    return DecodeStatus::bad_value;
  }
  datagram.header = {
      .session = envelope.session(), .sender = envelope.sender(), .sequence = envelope.sequence(), .send_time_ns = envelope.send_time_ns()};
  datagram.message = message;
  return DecodeStatus::ok;
}

// --- the kinds of messages: one line each, those that come most often first ---

template <class OursType, class TheirsType>
struct MessageKind {
  using Ours = OursType;
  using Theirs = TheirsType;
  bool (wire::Envelope::*has)() const;
  const Theirs& (wire::Envelope::*get)() const;
  Theirs* (wire::Envelope::*make)();
};

constexpr std::tuple kMessageKinds{
    MessageKind<DeviceState, wire::DeviceState>{&wire::Envelope::has_device_state, &wire::Envelope::device_state,
                                                &wire::Envelope::mutable_device_state},
    MessageKind<ForceCommand, wire::ForceCommand>{&wire::Envelope::has_force_command, &wire::Envelope::force_command,
                                                  &wire::Envelope::mutable_force_command},
    MessageKind<ProbeState, wire::ProbeState>{&wire::Envelope::has_probe_state, &wire::Envelope::probe_state,
                                              &wire::Envelope::mutable_probe_state},
    MessageKind<ViewTransform, wire::ViewTransform>{&wire::Envelope::has_view_transform, &wire::Envelope::view_transform,
                                                    &wire::Envelope::mutable_view_transform},
    MessageKind<Drawn, wire::Drawn>{&wire::Envelope::has_drawn, &wire::Envelope::drawn, &wire::Envelope::mutable_drawn},
    MessageKind<Hello, wire::Hello>{&wire::Envelope::has_hello, &wire::Envelope::hello, &wire::Envelope::mutable_hello},
    MessageKind<Welcome, wire::Welcome>{&wire::Envelope::has_welcome, &wire::Envelope::welcome, &wire::Envelope::mutable_welcome},
    MessageKind<HandTarget, wire::HandTarget>{&wire::Envelope::has_hand_target, &wire::Envelope::hand_target,
                                              &wire::Envelope::mutable_hand_target},
    MessageKind<Settings, wire::Settings>{&wire::Envelope::has_settings, &wire::Envelope::settings, &wire::Envelope::mutable_settings},
    MessageKind<HapticsSetup, wire::HapticsSetup>{&wire::Envelope::has_haptics_setup, &wire::Envelope::haptics_setup,
                                                  &wire::Envelope::mutable_haptics_setup},
    MessageKind<ReportAsk, wire::ReportAsk>{&wire::Envelope::has_report_ask, &wire::Envelope::report_ask,
                                            &wire::Envelope::mutable_report_ask},
    MessageKind<ReportPart, wire::ReportPart>{&wire::Envelope::has_report_part, &wire::Envelope::report_part,
                                              &wire::Envelope::mutable_report_part},
    MessageKind<SceneFacts, wire::SceneFacts>{&wire::Envelope::has_scene_facts, &wire::Envelope::scene_facts,
                                              &wire::Envelope::mutable_scene_facts},
    MessageKind<Bye, wire::Bye>{&wire::Envelope::has_bye, &wire::Envelope::bye, &wire::Envelope::mutable_bye},
};
constexpr std::size_t kKindCount = std::tuple_size_v<decltype(kMessageKinds)>;
static_assert(kKindCount == std::variant_size_v<Message>);
// Fields 1 to 5 of an Envelope are its header, the others one kind each, from 16 on.
static_assert(wire::Envelope::kSceneFactsFieldNumber == 15 + kKindCount, "the last kind of hapton.proto, and its line in kMessageKinds");

// Calls visit with each kind until one returns true.
template <class Visit>
bool visit_kinds(Visit&& visit) {
  return std::apply([&](const auto&... kind) { return (visit(kind) || ...); }, kMessageKinds);
}

DecodeStatus read_any(const wire::Envelope& e, Datagram& datagram) {
  const int kinds = std::apply([&](const auto&... kind) { return (static_cast<int>((e.*kind.has)()) + ...); }, kMessageKinds);
  if (kinds > 1) return DecodeStatus::bad_value;
  DecodeStatus status = DecodeStatus::unknown_message;
  visit_kinds([&](const auto& kind) {
    if (!(e.*kind.has)()) return false;
    status = read_message<typename std::decay_t<decltype(kind)>::Ours>(e, (e.*kind.get)(), datagram);
    return true;
  });
  return status;
}

// The version stands first and alone keeps its place in every version, so it is read before anything that may have changed.
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

// Every field ends within the datagram. The parser finds that out too, but only after it has reserved room for whatever length a
// message claims to have.
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

// The lite runtime keeps what it does not know in a string of its own, which only parsing reaches: one long unknown field, once,
// gives it the room it will ever need.
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
}
void reserve(wire::ProbeState& m) {
  reserve_field(*m.mutable_p_wd_m());
  reserve_field(*m.mutable_q_wt());
  reserve_field(*m.mutable_visual_offset_m());
  reserve_field(*m.mutable_force_n());
}
void reserve(wire::ViewTransform& m) { reserve_field(*m.mutable_x_ws()); }
void reserve(wire::Drawn&) {}
void reserve(wire::Hello&) {}
void reserve(wire::Welcome&) {}
void reserve(wire::HandTarget& m) { reserve_field(*m.mutable_p_wh_m()); }
void reserve(wire::Settings& m) { m.mutable_method()->reserve(kMaxDatagramBytes); }
void reserve(wire::HapticsSetup& m) {
  reserve_field(*m.mutable_x_ws());
  m.mutable_scene()->reserve(kMaxDatagramBytes);
  m.mutable_build()->reserve(kMaxDatagramBytes);
  m.mutable_method()->reserve(kMaxDatagramBytes);
  m.mutable_refusal()->reserve(kMaxDatagramBytes);
}
void reserve(wire::SceneFacts& m) {
  reserve_field(*m.mutable_lowest_m());
  reserve_field(*m.mutable_highest_m());
  reserve_field(*m.mutable_points_m());
}
void reserve(wire::ReportAsk&) {}
void reserve(wire::ReportPart& m) { m.mutable_text()->reserve(kMaxDatagramBytes); }
void reserve(wire::Bye&) {}

}  // namespace

// A sender and a receiver side, each an Envelope that owns one message of every kind.
struct Codec::Wire {
  wire::Envelope outgoing;
  wire::Envelope incoming;

  Wire() {
    reserve_all(outgoing);
    reserve_all(incoming);
  }

  static void reserve_all(wire::Envelope& e) {
    reserve_unknown(e);
    visit_kinds([&](const auto& kind) {
      auto& message = *(e.*kind.make)();
      reserve_unknown(message);
      reserve(message);
      return false;
    });
    e.Clear();
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
  }
  return "?";
}

Codec::Codec() : wire_(std::make_unique<Wire>()) {}
Codec::~Codec() = default;
Codec::Codec(Codec&&) noexcept = default;
Codec& Codec::operator=(Codec&&) noexcept = default;

std::size_t Codec::encode(const Datagram& datagram, std::span<std::byte> into) noexcept {
  wire::Envelope& e = wire_->outgoing;
  e.Clear();
  e.set_version(kProtocolVersion);
  e.set_session(datagram.header.session);
  e.set_sender(datagram.header.sender);
  e.set_sequence(datagram.header.sequence);
  e.set_send_time_ns(datagram.header.send_time_ns);
  visit_kinds([&](const auto& kind) {
    const auto* message = std::get_if<typename std::decay_t<decltype(kind)>::Ours>(&datagram.message);
    if (message != nullptr) write(*message, *(e.*kind.make)());
    return message != nullptr;
  });
  const std::size_t bytes = e.ByteSizeLong();
  if (bytes > into.size() || bytes > kMaxDatagramBytes) {
    return 0;
  }
  e.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(into.data()));
  return bytes;
}

DecodeStatus Codec::decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept {
  if (bytes.size() > kMaxDatagramBytes) {
    return DecodeStatus::bad_value;
  }
  const std::optional<std::uint64_t> version = peek_version(bytes);
  if (!version) {
    return DecodeStatus::truncated;
  }
  if (*version != kProtocolVersion) {
    return DecodeStatus::wrong_version;
  }
  wire::Envelope& e = wire_->incoming;
  if (!is_well_framed(bytes) || !e.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return DecodeStatus::truncated;
  }
  if (e.version() != kProtocolVersion) {
    return DecodeStatus::wrong_version;
  }
  return read_any(e, datagram);
}

}  // namespace hapton
