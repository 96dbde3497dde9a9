#include "recording/recording_shapes.h"

#include <utility>

namespace hapton {

Result<RecordingShapes> RecordingShapes::open(const std::filesystem::path& file) {
  auto reader = SessionReader::open(file);
  if (!reader) return tl::unexpected(reader.error());
  return RecordingShapes(std::move(*reader));
}

std::vector<ObjectShape> RecordingShapes::read(const IndexedShape& shape) {
  std::vector<ObjectShape> parts;
  if (!shape.first_position) return parts;
  reader_->seek(*shape.first_position);
  SessionEntry entry;
  for (std::uint64_t position = reader_->position(); position <= shape.last_position && reader_->next(entry);
       position = reader_->position()) {
    Datagram datagram;
    if (entry.kind != SessionEntry::Kind::received || entry.datagram.empty()) continue;
    if (codec_.decode(entry.datagram, datagram) != DecodeStatus::ok) continue;
    const auto* part = std::get_if<ObjectShape>(&datagram.message);
    if (part == nullptr || part->source != shape.start.source || part->serial != shape.start.serial) continue;
    if (part->object == shape.start.object) parts.push_back(*part);
  }
  return parts;
}

}  // namespace hapton
