#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "hapton.pb.h"
#include "link/protobuf_codec.h"
#include "link/wire_fields.h"

// Converts the messages about objects that programs deform to and from their form in proto/hapton.proto.
namespace hapton {
namespace {

static_assert(std::endian::native == std::endian::little, "the numbers on the wire are those of the machine");
constexpr std::size_t kBytesOfOne = sizeof(ShapePart::Displacement);  // of the displacement of one vertex
static_assert(kBytesOfOne == 12);

template <class Message>
void write_part(const ShapePart& from, Message& to) {
  to.set_total(from.total);
  to.set_first(from.first);
  to.mutable_displacements()->assign(reinterpret_cast<const char*>(from.displacements_m.data()), from.count() * kBytesOfOne);
}

template <class Message>
bool read_part(const Message& from, ShapePart& to) {
  to = {};
  to.total = from.total();
  to.first = from.first();
  if (to.total == 0 || to.total > ShapePart::kMaxVertices || to.first >= to.total || to.first % ShapePart::kVerticesPerPart != 0)
    return false;
  const std::string& bytes = from.displacements();
  if (bytes.size() != to.count() * kBytesOfOne) return false;
  std::memcpy(to.displacements_m.data(), bytes.data(), bytes.size());
  // Also false for NaN.
  const auto is_length = [](float x) { return std::abs(x) <= static_cast<float>(kMaxWireMagnitude); };
  return std::all_of(to.displacements_m.begin(), to.displacements_m.end(),
                     [&](const ShapePart::Displacement& one) { return std::all_of(one.begin(), one.end(), is_length); });
}

}  // namespace

void write(const ShapeRequest& from, wire::ShapeRequest& to) {
  to.set_stream(from.stream);
  to.set_shape(from.shape);
  write_text(from.object, *to.mutable_object());
  to.set_number(static_cast<std::uint32_t>(from.number));
  to.set_over_s(from.over_s);
  write_part(from.part, to);
}

void write(const ShapeReply& from, wire::ShapeReply& to) {
  to.set_stream(from.stream);
  to.set_shape(from.shape);
  write_text(from.rejection, *to.mutable_rejection());
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_over_s(from.over_s);
  to.set_serial(from.serial);
}

void write(const ObjectShape& from, wire::ObjectShape& to) {
  to.set_source(from.source);
  to.set_serial(from.serial);
  to.set_object(static_cast<std::uint32_t>(from.object));
  write_part(from.part, to);
}

void write(const ShapeStart& from, wire::ShapeStart& to) {
  to.set_source(from.source);
  to.set_serial(from.serial);
  to.set_before(from.before);
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_total(from.total);
  to.set_start_ns(from.start_ns);
  to.set_end_ns(from.end_ns);
}

void write(const ShapeStatus& from, wire::ShapeStatus& to) {
  to.set_source(from.source);
  to.set_serial(from.serial);
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_first(from.first);
  to.set_count(from.count);
}

bool read(const wire::ShapeRequest& from, ShapeRequest& to) {
  to.stream = from.stream();
  to.shape = from.shape();
  to.over_s = from.over_s();
  if (to.stream == 0 || to.shape == 0 || !(to.over_s >= 0.0 && to.over_s <= ShapeRequest::kMaxSeconds)) return false;
  return read_text(from.object(), to.object) && read_object_number(from.number(), to.number) && read_part(from, to.part);
}

bool read(const wire::ShapeReply& from, ShapeReply& to) {
  to.stream = from.stream();
  to.shape = from.shape();
  to.over_s = from.over_s();
  to.serial = from.serial();
  return to.stream != 0 && to.shape != 0 && is_amount(to.over_s) && read_object_number(from.object(), to.object) &&
         read_text(from.rejection(), to.rejection);
}

bool read(const wire::ObjectShape& from, ObjectShape& to) {
  to.source = from.source();
  to.serial = from.serial();
  return to.source != 0 && to.serial != 0 && read_object_number(from.object(), to.object) && read_part(from, to.part);
}

bool read(const wire::ShapeStart& from, ShapeStart& to) {
  to.source = from.source();
  to.serial = from.serial();
  to.before = from.before();
  to.total = from.total();
  to.start_ns = from.start_ns();
  to.end_ns = from.end_ns();
  if (to.source == 0 || to.total == 0 || to.total > ShapePart::kMaxVertices) return false;
  if (to.start_ns < 0 || to.end_ns < to.start_ns || !is_wire_time(to.end_ns)) return false;
  // Serial 0 is the object at rest: no shape comes before that.
  if (to.serial == 0 ? to.before != 0 : to.before >= to.serial) return false;
  return read_object_number(from.object(), to.object);
}

bool read(const wire::ShapeStatus& from, ShapeStatus& to) {
  to.source = from.source();
  to.serial = from.serial();
  to.first = from.first();
  to.count = from.count();
  if (to.source == 0 || to.serial == 0 || to.first >= ShapePart::kMaxVertices || to.first % ShapePart::kVerticesPerPart != 0) return false;
  if (to.count > ShapePart::kMaxParts * ShapePart::kVerticesPerPart || to.count % ShapePart::kVerticesPerPart != 0) return false;
  return read_object_number(from.object(), to.object);
}

}  // namespace hapton
