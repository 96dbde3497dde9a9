#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <boost/crc.hpp>

#include "core/base/result.h"
#include "runtime/part_file.h"

namespace hapton {

// Writes a file in the MCAP format, version 0 (https://mcap.dev/spec): messages in chunks of kChunkBytes without compression, each chunk
// with its message indexes; a summary with statistics and the index of the chunks; and all checksums of the format. Times: ns, in the
// caller's epoch. RT: no. Threads: one. The file appears at close(), complete, or not at all. Error: a full or failing disk does not stop
// the functions below; close() returns the first such error.
class McapWriter {
 public:
  static constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
  using Texts = std::map<std::string, std::string>;

  struct Schema {
    std::string name;
    std::string encoding;
    std::string data;
  };
  struct Channel {
    std::uint16_t schema = 0;  // 1 + the index of its schema in the list; 0: none
    std::string topic;
    std::string encoding;
  };

  // Begins the file with its schemas and channels. A channel's number is its index in the list. Error: one line with the path.
  static Result<McapWriter> open(const std::filesystem::path& path, const std::string& library, std::span<const Schema> schemas,
                                 std::span<const Channel> channels);

  // Pre: before the first message.
  void add_metadata(const std::string& name, const Texts& texts);
  // Pre: channel < the number of channels that open() got.
  void add_message(std::uint16_t channel, std::uint64_t log_ns, std::uint64_t publish_ns, std::string_view data);
  // Writes the last chunk, the summary and the end of the file. Error: one line: the file could not be completed, and does not appear.
  Result<void> close();

  std::uint64_t messages() const noexcept { return messages_; }

 private:
  struct IndexEntry {
    std::uint64_t log_ns = 0;
    std::uint64_t offset = 0;  // from the start of the chunk's messages
  };
  struct ChunkIndex {
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets = {};
    std::uint64_t index_bytes = 0;
    std::uint64_t record_bytes = 0;
  };
  struct MetadataIndex {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    std::string name;
  };
  explicit McapWriter(PartFile file) : file_(std::move(file)) {}
  void write(std::string_view bytes);
  void write_chunk();
  std::string make_summary() const;

  PartFile file_;
  std::uint64_t offset_ = 0;
  boost::crc_32_type crc_;  // over all bytes written so far
  std::string schema_records_;
  std::string channel_records_;
  std::size_t schema_count_ = 0;
  std::vector<std::uint64_t> counts_;     // messages of each channel
  std::vector<std::uint32_t> sequences_;  // newest sequence number of each channel
  std::vector<std::vector<IndexEntry>> index_;
  std::string chunk_;
  std::uint64_t chunk_first_ns_ = 0;
  std::uint64_t chunk_last_ns_ = 0;
  std::uint64_t first_ns_ = 0;
  std::uint64_t last_ns_ = 0;
  std::uint64_t messages_ = 0;
  std::vector<ChunkIndex> chunks_;
  std::vector<MetadataIndex> metadata_;
};

}  // namespace hapton
