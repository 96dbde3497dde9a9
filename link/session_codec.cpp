#include "link/session_codec.h"

#include <google/protobuf/io/coded_stream.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cstring>
#include <limits>

#include "core/base/valid_utf8.h"
#include "session.pb.h"

namespace hapton {
namespace {

// The file's enumerations have the same values as those of the code.
static_assert(static_cast<int>(session::FAULT_ENERGY) == static_cast<int>(SessionFault::energy) &&
              session::Fault_MAX == session::FAULT_ENERGY);
static_assert(static_cast<int>(session::MISS_CAUSE_MACHINE_STALLED) == static_cast<int>(MissCause::machine_stalled) &&
              session::MissCause_MAX == session::MISS_CAUSE_MACHINE_STALLED);

constexpr std::size_t kCheckBytes = 5;  // one of tag, four of value
constexpr char kCheckTag = 0x7D;        // field 15, fixed32
// No message of Hapton comes near this size; a greater length is damage.
constexpr std::uint32_t kMaxMessageBytes = 1 << 20;
constexpr std::size_t kMaxVarint32Bytes = 5;

std::uint32_t check_of(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

template <class WireMessage>
void append_checked(WireMessage& message, std::string& to) {
  using google::protobuf::io::CodedOutputStream;
  message.clear_check();
  const std::size_t body = message.ByteSizeLong();
  std::uint8_t length[10];
  const std::uint8_t* end = CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(body + kCheckBytes), length);
  to.append(reinterpret_cast<const char*>(length), static_cast<std::size_t>(end - length));
  const std::size_t begin = to.size();
  to.resize(begin + body + kCheckBytes);
  message.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(to.data() + begin));
  to[begin + body] = kCheckTag;
  CodedOutputStream::WriteLittleEndian32ToArray(check_of(std::string_view(to).substr(begin, body)),
                                                reinterpret_cast<std::uint8_t*>(to.data() + begin + body + 1));
}

struct Frame {
  SessionCodec::Read read;
  std::string_view message;
};

Frame find_frame(std::string_view bytes) {
  using google::protobuf::io::CodedInputStream;
  CodedInputStream input(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                         static_cast<int>(std::min<std::size_t>(bytes.size(), 2 * kMaxMessageBytes)));
  std::uint32_t length = 0;
  if (!input.ReadVarint32(&length)) {
    return {{bytes.size() < kMaxVarint32Bytes ? SessionCodec::Status::cut : SessionCodec::Status::damaged, 0}, {}};
  }
  if (length < kCheckBytes || length > kMaxMessageBytes) return {{SessionCodec::Status::damaged, 0}, {}};
  const auto prefix = static_cast<std::size_t>(input.CurrentPosition());
  if (bytes.size() - prefix < length) return {{SessionCodec::Status::cut, 0}, {}};
  const std::string_view message = bytes.substr(prefix, length);
  const std::string_view body = message.substr(0, length - kCheckBytes);
  std::uint32_t check = 0;
  CodedInputStream::ReadLittleEndian32FromArray(reinterpret_cast<const std::uint8_t*>(message.data() + body.size() + 1), &check);
  if (message[body.size()] != kCheckTag || check != check_of(body)) return {{SessionCodec::Status::damaged, 0}, {}};
  return {{SessionCodec::Status::ok, prefix + length}, message};
}

void write(const Address& from, std::span<const std::byte> bytes, session::Datagram& to) {
  to.set_ip(from.ip.data(), from.ip.size());
  to.set_port(from.port);
  to.set_envelope(bytes.data(), bytes.size());
}

bool read(const session::Datagram& from, SessionEntry& to) {
  if (from.ip().size() != to.peer.ip.size() || from.port() > 0xFFFF) return false;
  std::memcpy(to.peer.ip.data(), from.ip().data(), to.peer.ip.size());
  to.peer.port = static_cast<std::uint16_t>(from.port());
  to.datagram = std::as_bytes(std::span(from.envelope().data(), from.envelope().size()));
  return true;
}

bool read(const session::Cycle& from, CycleNote& to) {
  if (from.written_n_size() != 3) return false;
  to.sample = from.sample();
  to.late_ns = from.late_ns();
  to.written_n = Vec3(from.written_n(0), from.written_n(1), from.written_n(2));
  to.missed = from.missed();
  to.cause = static_cast<MissCause>(std::clamp<int>(from.cause(), 0, 255));
  if (from.p_wd_m_size() != 0) {
    if (from.p_wd_m_size() != 3 || from.q_wt_size() != 4) return false;
    to.device = CycleSample{from.sample_time_ns(), Vec3(from.p_wd_m().data()), Quat(from.q_wt(0), from.q_wt(1), from.q_wt(2), from.q_wt(3)),
                            from.buttons()};
  }
  if (from.written_nm_size() != 0) {
    if (from.written_nm_size() != 3) return false;
    to.written_nm = Vec3(from.written_nm().data());
  }
  if (from.local_size() != 0) {
    if (from.local_size() != 6) return false;
    const bool is_object = from.local_touched() <= static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
    const std::int32_t object = is_object ? static_cast<std::int32_t>(from.local_touched()) - 1 : -1;
    to.local = CycleLocal{Vec3(from.local().data()), Vec3(from.local().data() + 3), object};
  }
  return true;
}

void add(const Vec3& from, google::protobuf::RepeatedField<double>& to) { to.Add(from.data(), from.data() + 3); }

void write(const Vec3& from, google::protobuf::RepeatedField<double>& to) {
  to.Clear();
  add(from, to);
}

void write(const CycleNote& from, session::Cycle& to) {
  to.set_sample(from.sample);
  to.set_late_ns(from.late_ns);
  write(from.written_n, *to.mutable_written_n());
  to.set_missed(from.missed);
  to.set_cause(static_cast<session::MissCause>(from.cause));
  if (from.device) {
    to.set_sample_time_ns(from.device->time_ns);
    write(from.device->p_WD, *to.mutable_p_wd_m());
    const Quat& q = from.device->q_WT;
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) to.add_q_wt(part);
    to.set_buttons(from.device->buttons);
  }
  if (from.local) {
    add(from.local->force_n, *to.mutable_local());
    add(from.local->visual_offset_m, *to.mutable_local());
    to.set_local_touched(from.local->object < 0 ? 0U : static_cast<std::uint32_t>(from.local->object) + 1U);
  }
  if (!from.written_nm.isZero(0.0)) write(from.written_nm, *to.mutable_written_nm());
}

void write(const MarkerNote& from, session::Marker& to) {
  to.set_sample(from.sample);
  to.set_text(from.text.data(), from.text.size());
  to.set_source(static_cast<std::uint32_t>(from.source));
}

bool read(const session::Marker& from, MarkerNote& to) {
  to.sample = from.sample();
  to.text = from.text();
  to.source = static_cast<NodeRole>(from.source());
  const bool is_role =
      from.source() >= static_cast<std::uint32_t>(NodeRole::io) && from.source() <= static_cast<std::uint32_t>(NodeRole::tool);
  return is_role && MarkerText::is_valid(to.text);
}

}  // namespace

struct SessionCodec::Wire {
  session::Entry entry;
  session::Header header;
  session::Cycle cycle;
  session::Event event;
  session::Shape shape;
};

SessionCodec::SessionCodec() : wire_(std::make_unique<Wire>()) {}
SessionCodec::~SessionCodec() = default;
SessionCodec::SessionCodec(SessionCodec&&) noexcept = default;
SessionCodec& SessionCodec::operator=(SessionCodec&&) noexcept = default;

void SessionCodec::append(const SessionHeader& header, std::string& to) {
  session::Header& h = wire_->header;
  h.Clear();
  h.set_build(to_valid_utf8(header.build));
  h.set_start_ns(header.start_ns);
  h.set_start_unix_ns(header.start_unix_ns);
  h.set_session(header.session);
  h.set_fault(to_valid_utf8(header.fault));
  for (const auto& [name, value] : header.settings) {
    session::Setting& setting = *h.add_settings();
    setting.set_name(to_valid_utf8(name));
    setting.set_value(to_valid_utf8(value));
  }
  h.set_has_end(header.has_end);
  append_checked(h, to);
}

void SessionCodec::append(const SessionEntry& entry, std::string& to) {
  session::Entry& wire_entry = wire_->entry;
  wire_entry.Clear();
  wire_entry.set_time_ns(entry.time_ns);
  switch (entry.kind) {
    case SessionEntry::Kind::received:
      write(entry.peer, entry.datagram, *wire_entry.mutable_received());
      break;
    case SessionEntry::Kind::sent:
      write(entry.peer, entry.datagram, *wire_entry.mutable_sent());
      break;
    case SessionEntry::Kind::cycle:
      write(entry.cycle, *wire_entry.mutable_cycle());
      break;
    case SessionEntry::Kind::fault:
      wire_entry.set_fault(static_cast<session::Fault>(entry.fault));
      break;
    case SessionEntry::Kind::dropped:
      wire_entry.set_dropped(entry.dropped);
      break;
    case SessionEntry::Kind::marker:
      write(entry.marker, *wire_entry.mutable_marker());
      break;
    case SessionEntry::Kind::end:
      wire_entry.set_end(true);
      break;
  }
  append_checked(wire_entry, to);
}

void SessionCodec::append_alone(const CycleNote& cycle, std::string& to) {
  session::Cycle& c = wire_->cycle;
  c.Clear();
  write(cycle, c);
  c.AppendToString(&to);
}

void SessionCodec::append_alone(const SessionEvent& event, std::string& to) {
  session::Event& e = wire_->event;
  e.set_kind(event.kind.data(), event.kind.size());
  e.set_name(event.name);
  e.set_sample(event.sample);
  e.AppendToString(&to);
}

void SessionCodec::append_alone(const SessionShape& shape, std::string& to) {
  session::Shape& s = wire_->shape;
  s.Clear();
  s.set_process(shape.process);
  s.set_serial(shape.start.serial);
  s.set_before(shape.start.before);
  s.set_object(static_cast<std::uint32_t>(shape.start.object));
  s.set_vertices(shape.start.total);
  s.set_start_ns(shape.start.start_ns);
  s.set_end_ns(shape.start.end_ns);
  for (const ShapePart::Displacement& displacement : shape.displacements_m) {
    for (const float component : displacement) s.add_displacements_m(component);
  }
  s.AppendToString(&to);
}

SessionCodec::Read SessionCodec::read(std::string_view bytes, SessionHeader& header) {
  const Frame frame = find_frame(bytes);
  if (frame.read.status != Status::ok) return frame.read;
  session::Header& h = wire_->header;
  if (!h.ParseFromArray(frame.message.data(), static_cast<int>(frame.message.size()))) return {Status::damaged, 0};
  header = {h.build(), h.start_ns(), h.start_unix_ns(), h.session(), h.fault(), {}, h.has_end()};
  for (const session::Setting& setting : h.settings()) header.settings.emplace_back(setting.name(), setting.value());
  return frame.read;
}

SessionCodec::Read SessionCodec::read(std::string_view bytes, SessionEntry& entry) {
  const Frame frame = find_frame(bytes);
  if (frame.read.status != Status::ok) return frame.read;
  session::Entry& wire_entry = wire_->entry;
  if (!wire_entry.ParseFromArray(frame.message.data(), static_cast<int>(frame.message.size()))) return {Status::damaged, 0};
  entry = {};
  entry.time_ns = wire_entry.time_ns();
  bool is_good = true;
  if (wire_entry.has_received()) {
    entry.kind = SessionEntry::Kind::received;
    is_good = hapton::read(wire_entry.received(), entry);
  } else if (wire_entry.has_sent()) {
    entry.kind = SessionEntry::Kind::sent;
    is_good = hapton::read(wire_entry.sent(), entry);
  } else if (wire_entry.has_cycle()) {
    entry.kind = SessionEntry::Kind::cycle;
    is_good = hapton::read(wire_entry.cycle(), entry.cycle);
  } else if (wire_entry.has_fault()) {
    entry.kind = SessionEntry::Kind::fault;
    entry.fault = static_cast<SessionFault>(std::clamp<int>(wire_entry.fault(), 0, 255));
  } else if (wire_entry.has_dropped()) {
    entry.kind = SessionEntry::Kind::dropped;
    entry.dropped = wire_entry.dropped();
  } else if (wire_entry.has_marker()) {
    entry.kind = SessionEntry::Kind::marker;
    is_good = hapton::read(wire_entry.marker(), entry.marker);
  } else if (wire_entry.end()) {
    entry.kind = SessionEntry::Kind::end;
  } else {
    return {Status::unknown, frame.read.bytes};
  }
  return is_good ? frame.read : Read{Status::damaged, 0};
}

}  // namespace hapton
