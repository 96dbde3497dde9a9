#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "link/session_codec.h"

namespace hapton {

// Reads a session file of any length, entry by entry.
// RT: no. Threads: one.
class SessionReader {
 public:
  // Error, one line: no such file, it cannot be read, it is not a recorded session, another schema, or a damaged header.
  static Result<SessionReader> open(const std::filesystem::path& path);

  const SessionHeader& header() const { return header_; }

  // Reads the next entry, not `end`; false at the end of the readable data. Post: entry.datagram and the marker's text are valid until the
  // next call.
  bool next(SessionEntry& entry);

  // The byte of the file at which the next entry begins.
  std::uint64_t position() const { return buffer_offset_ + begin_; }
  // Continues to read at `position`. Pre: a reader of the same file has returned it from position(). Post: problem() is empty.
  void seek(std::uint64_t position);

  // After next returned false: empty if the file is complete, else one line that says where and how it is truncated, or why it cannot be
  // read further; the line counts the entries since the last seek. A file that ends between two entries is complete if the last entry read
  // is an end, or if its header promises none.
  const std::string& problem() const { return problem_; }

 private:
  SessionReader() = default;
  bool refill();
  std::string describe_count() const;

  std::filesystem::path path_;
  std::unique_ptr<std::ifstream> file_;
  SessionCodec codec_;
  SessionHeader header_;
  std::string buffer_;
  std::size_t begin_ = 0;                // first unread byte in the buffer
  std::uint64_t buffer_offset_ = 0;      // position of the buffer's front in the file
  std::uint64_t entries_ = 0;            // that next() returned since the file was opened, or since the last seek
  std::optional<std::uint64_t> sought_;  // the position of the last seek
  bool has_ended_ = false;
  std::string problem_;
};

}  // namespace hapton
