#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "link/session_codec.h"

namespace hapton {

// Reads a session file of any length, entry by entry.
// RT: no. Threads: one.
class SessionReader {
 public:
  // Error, in one line: no such file or one that cannot be read, no session, another schema, a damaged header.
  static Result<SessionReader> open(const std::filesystem::path& path);

  const SessionHeader& header() const { return header_; }

  // The next entry, but for the end; false at the end of the readable data. Post: entry.datagram and the marker's text are valid until the
  // next call.
  bool next(SessionEntry& entry);

  // Where the next entry begins in the file, bytes.
  std::uint64_t position() const { return buffer_offset_ + begin_; }
  // Goes on reading there. Pre: position() was this once, of a reader of the same file. Post: problem() is empty.
  void seek(std::uint64_t position);

  // After next returned false: empty if the file is complete, else one line that says where and how it is truncated, or why it cannot be
  // read on. A file that ends between two entries is complete if an end is among what was read, or if its header promises none.
  const std::string& problem() const { return problem_; }

 private:
  SessionReader() = default;
  bool refill();

  std::filesystem::path path_;
  std::unique_ptr<std::ifstream> file_;
  SessionCodec codec_;
  SessionHeader header_;
  std::string buffer_;
  std::size_t begin_ = 0;            // first unread byte in the buffer
  std::uint64_t buffer_offset_ = 0;  // of the buffer's front, in the file
  std::uint64_t entries_ = 0;
  bool has_ended_ = false;
  std::string problem_;
};

}  // namespace hapton
