#include "hapton.pb.h"
#include "link/protobuf_codec.h"
#include "link/wire_fields.h"

// Converts the messages that move objects to and from their form in proto/hapton.proto.
namespace hapton {

void write(const MoveRequest& from, wire::MoveRequest& to) {
  to.set_request(from.request);
  write_text(from.object, *to.mutable_object());
  to.set_number(static_cast<std::uint32_t>(from.number));
  to.mutable_p_m()->Clear();
  to.mutable_q()->Clear();
  to.clear_over_s();
  if (from.p_m) write_vector(*to.mutable_p_m(), *from.p_m);
  if (from.q) write_rotation(*to.mutable_q(), *from.q);
  if (from.over_s) to.set_over_s(*from.over_s);
}

void write(const MoveReply& from, wire::MoveReply& to) {
  to.set_request(from.request);
  write_text(from.rejection, *to.mutable_rejection());
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_over_s(from.over_s);
  to.set_serial(from.serial);
}

void write(const ObjectMove& from, wire::ObjectMove& to) {
  to.set_source(from.source);
  to.set_serial(from.serial);
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_start_ns(from.start_ns);
  to.set_end_ns(from.end_ns);
  write_vector(*to.mutable_from_p_m(), from.from_p_m);
  write_rotation(*to.mutable_from_q(), from.from_q);
  write_vector(*to.mutable_to_p_m(), from.to_p_m);
  write_rotation(*to.mutable_to_q(), from.to_q);
  write_text(from.name, *to.mutable_name());
}

bool read(const wire::MoveRequest& from, MoveRequest& to) {
  to = {};
  to.request = from.request();
  const bool has_position = !from.p_m().empty();
  const bool has_rotation = !from.q().empty();
  if (to.request == 0 || !(has_position || has_rotation)) return false;
  if (has_position && !read_vector(from.p_m(), to.p_m.emplace())) return false;
  if (has_rotation && !read_rotation(from.q(), to.q.emplace())) return false;
  if (from.has_over_s() && !(from.over_s() > 0.0 && from.over_s() <= MoveRequest::kMaxSeconds)) return false;
  if (from.has_over_s()) to.over_s = from.over_s();
  return read_text(from.object(), to.object) && read_object_number(from.number(), to.number);
}

bool read(const wire::MoveReply& from, MoveReply& to) {
  to.request = from.request();
  to.over_s = from.over_s();
  to.serial = from.serial();
  return to.request != 0 && is_amount(to.over_s) && read_object_number(from.object(), to.object) &&
         read_text(from.rejection(), to.rejection);
}

bool read(const wire::ObjectMove& from, ObjectMove& to) {
  to.source = from.source();
  to.serial = from.serial();
  to.start_ns = from.start_ns();
  to.end_ns = from.end_ns();
  if (to.source == 0 || to.start_ns < 0 || to.end_ns < to.start_ns || !is_wire_time(to.end_ns)) return false;
  return read_object_number(from.object(), to.object) && read_vector(from.from_p_m(), to.from_p_m) &&
         read_rotation(from.from_q(), to.from_q) && read_vector(from.to_p_m(), to.to_p_m) && read_rotation(from.to_q(), to.to_q) &&
         read_text(from.name(), to.name);
}

}  // namespace hapton
