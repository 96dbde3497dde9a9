#include "tools/session/session_mcap.h"

#include <fmt/core.h>

#include <array>
#include <string>
#include <utility>
#include <variant>

#include "link/message_payload.h"
#include "link/wire_schema.h"
#include "recording/recording_entries.h"
#include "recording/recording_shape_collector.h"
#include "tools/session/csv_names.h"
#include "tools/session/mcap_writer.h"

namespace hapton {
namespace {

enum class McapTopic : std::uint16_t { cycle, state, force, probe, view, setup, move, carve, event, object_pose, material, shape };

constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kMcapTopics = {{
    {"/hapton/cycle", "hapton.session.Cycle"},
    {"/hapton/state", "hapton.wire.DeviceState"},
    {"/hapton/force", "hapton.wire.ForceCommand"},
    {"/hapton/probe", "hapton.wire.ProbeState"},
    {"/hapton/view", "hapton.wire.ViewTransform"},
    {"/hapton/setup", "hapton.wire.HapticsSetup"},
    {"/hapton/move", "hapton.wire.ObjectMove"},
    {"/hapton/carve", "hapton.wire.Carves"},
    {"/hapton/event", "hapton.session.Event"},
    {"/hapton/object_pose", "hapton.wire.ObjectPose"},
    {"/hapton/material", "hapton.wire.MaterialState"},
    {"/hapton/shape", "hapton.session.Shape"},
}};

Result<McapWriter> open_mcap(const std::filesystem::path& path) {
  std::vector<McapWriter::Schema> schemas;
  std::vector<McapWriter::Channel> channels;
  for (const auto& [topic, message] : kMcapTopics) {
    schemas.push_back({std::string(message), "protobuf", std::string(wire_schema())});
    channels.push_back({static_cast<std::uint16_t>(schemas.size()), std::string(topic), "protobuf"});
  }
  return McapWriter::open(path, "hapton", schemas, channels);
}

McapWriter::Texts describe_header(const SessionHeader& header) {
  McapWriter::Texts texts = {{"build", header.build},
                             {"session", fmt::format("{:016x}", header.session)},
                             {"start_unix_ns", fmt::format("{}", header.start_unix_ns)},
                             {"fault", header.fault}};
  for (const auto& [name, value] : header.settings) texts["setting " + name] = value;
  return texts;
}

McapWriter::Texts describe_objects(std::span<const ObjectName> names) {
  McapWriter::Texts texts;
  for (std::size_t n = 0; n < names.size(); ++n) {
    texts[fmt::format("{} name", n)] = whole_text(names[n].object);
    texts[fmt::format("{} material", n)] = whole_text(names[n].material);
  }
  return texts;
}

// Writes the entries of a recording as messages, one after the other.
class McapMessages {
 public:
  McapMessages(McapWriter& writer, const SessionHeader& header) : writer_(writer), header_(header), shapes_(header.start_ns) {}

  // Writes the shapes whose last part did not come.
  void finish() {
    shapes_.finish([this](const RecordedShape& shape) { add_shape(shape); });
  }
  void add(const SessionEntry& entry, const Datagram* datagram) {
    shapes_.add(entry, datagram, [this](const RecordedShape& shape) { add_shape(shape); });
    switch (entry.kind) {
      case SessionEntry::Kind::cycle:
        return add_cycle(entry);
      case SessionEntry::Kind::fault:
        return add_event(entry, {"fault", std::string(to_string(entry.fault)), sample_});
      case SessionEntry::Kind::marker:
        return add_event(entry, {"marker", std::string(entry.marker.text), entry.marker.sample});
      case SessionEntry::Kind::dropped:
        return add_event(entry, {"dropped", fmt::format("{} entries", entry.dropped), sample_});
      case SessionEntry::Kind::received:
      case SessionEntry::Kind::sent:
        if (datagram != nullptr) add_datagram(entry, *datagram);
        return;
      case SessionEntry::Kind::end:
        return;
    }
  }
  std::uint64_t cycles() const { return cycles_; }

 private:
  // The times come from a file, which may contain any number: so unsigned arithmetic is used, and a time out of range becomes 0.
  std::uint64_t unix_ns(std::int64_t hub_ns) const {
    const std::uint64_t ns = static_cast<std::uint64_t>(header_.start_unix_ns) +
                             (static_cast<std::uint64_t>(hub_ns) - static_cast<std::uint64_t>(header_.start_ns));
    return ns > static_cast<std::uint64_t>(INT64_MAX) ? 0 : ns;
  }
  void write(McapTopic topic, std::int64_t log_ns, std::int64_t publish_ns, std::string_view data) {
    writer_.add_message(static_cast<std::uint16_t>(topic), unix_ns(log_ns), unix_ns(publish_ns), data);
  }
  void add_cycle(const SessionEntry& entry) {
    if (cycles_++ > 0 && entry.cycle.sample > sample_ + 1)
      add_event(entry, {"lost", fmt::format("{} samples", entry.cycle.sample - sample_ - 1), entry.cycle.sample});
    sample_ = entry.cycle.sample;
    buffer_.clear();
    codec_.append_alone(entry.cycle, buffer_);
    write(McapTopic::cycle, entry.time_ns, entry.cycle.device ? entry.cycle.device->time_ns : entry.time_ns, buffer_);
  }
  void add_event(const SessionEntry& entry, const SessionEvent& event) {
    buffer_.clear();
    codec_.append_alone(event, buffer_);
    write(McapTopic::event, entry.time_ns, entry.time_ns, buffer_);
  }
  void add_shape(const RecordedShape& shape) {
    buffer_.clear();
    codec_.append_alone(SessionShape{.process = shape.process, .start = shape.start, .displacements_m = shape.displacements_m}, buffer_);
    write(McapTopic::shape, shape.time_ns, shape.time_ns, buffer_);
  }
  void add_datagram(const SessionEntry& entry, const Datagram& datagram) {
    const bool is_sent = entry.kind == SessionEntry::Kind::sent;
    const std::string_view payload = find_message_payload(entry.datagram);
    if (const auto* state = std::get_if<DeviceState>(&datagram.message); state != nullptr && is_sent)
      return write(McapTopic::state, entry.time_ns, state->sample_time_ns, payload);
    if (const auto* probe = std::get_if<ProbeState>(&datagram.message); probe != nullptr && is_sent)
      return write(McapTopic::probe, entry.time_ns, probe->sample_time_ns, payload);
    if (is_sent) return;
    if (std::holds_alternative<ForceCommand>(datagram.message)) write(McapTopic::force, entry.time_ns, entry.time_ns, payload);
    if (std::holds_alternative<ViewTransform>(datagram.message)) write(McapTopic::view, entry.time_ns, entry.time_ns, payload);
    if (std::holds_alternative<HapticsSetup>(datagram.message)) write(McapTopic::setup, entry.time_ns, entry.time_ns, payload);
    if (std::holds_alternative<ObjectMove>(datagram.message)) write(McapTopic::move, entry.time_ns, entry.time_ns, payload);
    if (std::holds_alternative<Carves>(datagram.message)) write(McapTopic::carve, entry.time_ns, entry.time_ns, payload);
    if (std::holds_alternative<ObjectPose>(datagram.message)) write(McapTopic::object_pose, entry.time_ns, entry.time_ns, payload);
    if (std::holds_alternative<MaterialState>(datagram.message)) write(McapTopic::material, entry.time_ns, entry.time_ns, payload);
  }

  McapWriter& writer_;
  const SessionHeader& header_;
  RecordingShapeCollector shapes_;
  SessionCodec codec_;
  std::string buffer_;
  std::uint64_t sample_ = 0;
  std::uint64_t cycles_ = 0;
};

}  // namespace

Result<McapCounts> write_mcap(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names) {
  auto writer = open_mcap(path);
  if (!writer) return tl::unexpected(writer.error());
  writer->add_metadata("hapton.session", describe_header(reader.header()));
  if (!names.empty()) writer->add_metadata("hapton.objects", describe_objects(names));
  McapMessages messages(*writer, reader.header());
  (void)for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    messages.add(entry, datagram);
    return {};
  });
  messages.finish();
  if (const auto closed = writer->close(); !closed) return tl::unexpected(closed.error());
  return McapCounts{messages.cycles(), writer->messages()};
}

}  // namespace hapton
