#include "tools/session/mcap_writer.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace hapton {
namespace {

constexpr std::string_view kMcapMagic = "\x89MCAP0\r\n";

// The record types of the MCAP specification.
enum class McapOp : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  statistics = 11,
  metadata = 12,
  metadata_index = 13,
  summary_offset = 14,
  data_end = 15,
};

// Bytes in the encoding of MCAP. Numbers are little-endian; a text, an array and a map begin with their length.
class McapBytes {
 public:
  template <class Number>
  McapBytes& add(Number value) {
    static_assert(std::is_unsigned_v<Number>);
    for (std::size_t i = 0; i < sizeof value; ++i) bytes_ += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i));
    return *this;
  }
  McapBytes& add_text(std::string_view text) {
    add(static_cast<std::uint32_t>(text.size()));
    bytes_ += text;
    return *this;
  }
  McapBytes& add_raw(std::string_view raw) {
    bytes_ += raw;
    return *this;
  }
  McapBytes& add_texts(const McapWriter::Texts& texts) {
    McapBytes all;
    for (const auto& [key, value] : texts) all.add_text(key).add_text(value);
    return add_text(all.bytes_);
  }
  template <class Key>
  McapBytes& add_counts(const std::map<Key, std::uint64_t>& counts) {
    McapBytes all;
    for (const auto& [key, value] : counts) all.add(key).add(value);
    return add_text(all.bytes_);
  }
  const std::string& bytes() const { return bytes_; }
  std::string as_record(McapOp op) const {
    McapBytes record;
    record.add(static_cast<std::uint8_t>(op)).add(std::uint64_t{bytes_.size()}).add_raw(bytes_);
    return std::move(record.bytes_);
  }

 private:
  std::string bytes_;
};

std::uint32_t crc_of(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace

Result<McapWriter> McapWriter::open(const std::filesystem::path& path, const std::string& library, std::span<const Schema> schemas,
                                    std::span<const Channel> channels) {
  auto file = PartFile::open(path);
  if (!file) return tl::unexpected(file.error());
  McapWriter writer(std::move(*file));
  for (const Schema& schema : schemas) {
    const auto number = static_cast<std::uint16_t>(++writer.schema_count_);
    writer.schema_records_ +=
        McapBytes().add(number).add_text(schema.name).add_text(schema.encoding).add_text(schema.data).as_record(McapOp::schema);
  }
  for (const Channel& channel : channels) {
    const auto number = static_cast<std::uint16_t>(writer.counts_.size());
    writer.channel_records_ += McapBytes()
                                   .add(number)
                                   .add(channel.schema)
                                   .add_text(channel.topic)
                                   .add_text(channel.encoding)
                                   .add_texts({})
                                   .as_record(McapOp::channel);
    writer.counts_.push_back(0);
  }
  writer.sequences_.resize(channels.size());
  writer.index_.resize(channels.size());
  writer.write(kMcapMagic);
  writer.write(McapBytes().add_text("").add_text(library).as_record(McapOp::header));
  writer.write(writer.schema_records_);
  writer.write(writer.channel_records_);
  return writer;
}

// After a failure nothing more is written: the first reason is the one to report.
void McapWriter::write(std::string_view bytes) {
  if (file_.is_good()) file_.check(std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size());
  crc_.process_bytes(bytes.data(), bytes.size());
  offset_ += bytes.size();
}

void McapWriter::add_metadata(const std::string& name, const Texts& texts) {
  const std::string record = McapBytes().add_text(name).add_texts(texts).as_record(McapOp::metadata);
  metadata_.push_back({offset_, record.size(), name});
  write(record);
}

void McapWriter::add_message(std::uint16_t channel, std::uint64_t log_ns, std::uint64_t publish_ns, std::string_view data) {
  if (chunk_.empty()) chunk_first_ns_ = chunk_last_ns_ = log_ns;
  if (messages_ == 0) first_ns_ = last_ns_ = log_ns;
  chunk_first_ns_ = std::min(chunk_first_ns_, log_ns);
  chunk_last_ns_ = std::max(chunk_last_ns_, log_ns);
  first_ns_ = std::min(first_ns_, log_ns);
  last_ns_ = std::max(last_ns_, log_ns);
  index_[channel].push_back({log_ns, chunk_.size()});
  chunk_ += McapBytes().add(channel).add(++sequences_[channel]).add(log_ns).add(publish_ns).add_raw(data).as_record(McapOp::message);
  ++counts_[channel];
  ++messages_;
  if (chunk_.size() >= kChunkBytes) write_chunk();
}

void McapWriter::write_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index{.first_ns = chunk_first_ns_, .last_ns = chunk_last_ns_, .offset = offset_, .record_bytes = chunk_.size()};
  const std::string record = McapBytes()
                                 .add(chunk_first_ns_)
                                 .add(chunk_last_ns_)
                                 .add(std::uint64_t{chunk_.size()})
                                 .add(crc_of(chunk_))
                                 .add_text("")
                                 .add(std::uint64_t{chunk_.size()})
                                 .add_raw(chunk_)
                                 .as_record(McapOp::chunk);
  index.bytes = record.size();
  write(record);
  for (std::size_t channel = 0; channel < index_.size(); ++channel) {
    std::vector<IndexEntry>& entries = index_[channel];
    if (entries.empty()) continue;
    std::stable_sort(entries.begin(), entries.end(), [](const IndexEntry& a, const IndexEntry& b) { return a.log_ns < b.log_ns; });
    McapBytes all;
    for (const IndexEntry& entry : entries) all.add(entry.log_ns).add(entry.offset);
    const auto number = static_cast<std::uint16_t>(channel);
    index.index_offsets[number] = offset_;
    const std::string indexed = McapBytes().add(number).add_text(all.bytes()).as_record(McapOp::message_index);
    index.index_bytes += indexed.size();
    write(indexed);
    entries.clear();
  }
  chunks_.push_back(std::move(index));
  chunk_.clear();
}

// The summary of the file: groups of records by type, then the position of each group, then the footer.
std::string McapWriter::make_summary() const {
  std::string summary;
  std::string offsets;
  const auto add_group = [&](McapOp op, const std::string& records) {
    if (records.empty()) return;
    offsets += McapBytes()
                   .add(static_cast<std::uint8_t>(op))
                   .add(offset_ + summary.size())
                   .add(std::uint64_t{records.size()})
                   .as_record(McapOp::summary_offset);
    summary += records;
  };
  add_group(McapOp::schema, schema_records_);
  add_group(McapOp::channel, channel_records_);
  std::map<std::uint16_t, std::uint64_t> counts;
  for (std::size_t channel = 0; channel < counts_.size(); ++channel) counts[static_cast<std::uint16_t>(channel)] = counts_[channel];
  add_group(McapOp::statistics, McapBytes()
                                    .add(messages_)
                                    .add(static_cast<std::uint16_t>(schema_count_))
                                    .add(static_cast<std::uint32_t>(counts_.size()))
                                    .add(std::uint32_t{0})
                                    .add(static_cast<std::uint32_t>(metadata_.size()))
                                    .add(static_cast<std::uint32_t>(chunks_.size()))
                                    .add(first_ns_)
                                    .add(last_ns_)
                                    .add_counts(counts)
                                    .as_record(McapOp::statistics));
  std::string records;
  for (const ChunkIndex& chunk : chunks_) {
    records += McapBytes()
                   .add(chunk.first_ns)
                   .add(chunk.last_ns)
                   .add(chunk.offset)
                   .add(chunk.bytes)
                   .add_counts(chunk.index_offsets)
                   .add(chunk.index_bytes)
                   .add_text("")
                   .add(chunk.record_bytes)
                   .add(chunk.record_bytes)
                   .as_record(McapOp::chunk_index);
  }
  add_group(McapOp::chunk_index, records);
  records.clear();
  for (const MetadataIndex& metadata : metadata_)
    records += McapBytes().add(metadata.offset).add(metadata.bytes).add_text(metadata.name).as_record(McapOp::metadata_index);
  add_group(McapOp::metadata_index, records);
  // The footer's checksum covers the summary and the footer itself up to its first two numbers.
  McapBytes footer;
  footer.add(offset_).add(offset_ + summary.size());
  std::string end = summary + offsets;
  const std::string footer_begin = McapBytes().add_raw(footer.bytes()).add(std::uint32_t{0}).as_record(McapOp::footer);
  const std::uint32_t crc = crc_of(end + footer_begin.substr(0, footer_begin.size() - sizeof(std::uint32_t)));
  return end + McapBytes().add_raw(footer.bytes()).add(crc).as_record(McapOp::footer);
}

Result<void> McapWriter::close() {
  write_chunk();
  write(McapBytes().add(static_cast<std::uint32_t>(crc_.checksum())).as_record(McapOp::data_end));
  write(make_summary());
  write(kMcapMagic);
  if (auto closed = file_.close(); !closed) return closed;
  return file_.keep();
}

}  // namespace hapton
