#include "link/session_reader.h"

#include <cerrno>
#include <cstring>

namespace hapton {
namespace {

constexpr std::size_t kRefillBytes = 1 << 20;  // 1 MiB at a time

}  // namespace

// Moves unread bytes to the front and reads more; false at the end of the file, or if nothing could be read.
bool SessionReader::refill() {
  buffer_.erase(0, begin_);
  buffer_offset_ += begin_;
  begin_ = 0;
  const std::size_t before = buffer_.size();
  buffer_.resize(before + kRefillBytes);
  file_->read(buffer_.data() + before, kRefillBytes);
  // If a disk or a network share fails, this is not the end of the file: it is reported.
  if (file_->bad()) {
    problem_ = fmt::format("{}: cannot be read after {}, at byte {}: {}", path_.string(), describe_count(), buffer_offset_ + before,
                           std::strerror(errno));
  }
  buffer_.resize(before + static_cast<std::size_t>(file_->gcount()));
  return buffer_.size() > before;
}

Result<SessionReader> SessionReader::open(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) return fail("{}: is a folder, not a recorded session", path.string());
  // Opening a pipe would wait for a writer.
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return fail("{}: is not a regular file: copy it to one", path.string());
  }
  SessionReader reader;
  reader.path_ = path;
  reader.file_ = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*reader.file_) {
    return fail("{}: cannot be read: {}; give a file that io_node --record made", path.string(), std::strerror(errno));
  }
  reader.refill();
  if (!reader.problem_.empty()) return fail("{}", reader.problem_);
  const std::string_view bytes = reader.buffer_;
  constexpr std::string_view kStem = kSessionMagic.substr(0, kSessionMagic.find('/') + 1);
  if (!bytes.starts_with(kStem)) return fail("{}: is not a recorded session; io_node --record FILE makes one", path.string());
  if (!bytes.starts_with(kSessionMagic)) {
    return fail("{}: is a recorded session of another schema than {}; read it with the build that wrote it", path.string(),
                kSessionMagic.substr(0, kSessionMagic.size() - 1));
  }
  const SessionCodec::Read read = reader.codec_.read(bytes.substr(kSessionMagic.size()), reader.header_);
  if (read.status != SessionCodec::Status::ok) return fail("{}: its header is damaged or cut short; nothing can be read", path.string());
  reader.begin_ = kSessionMagic.size() + read.bytes;
  return reader;
}

void SessionReader::seek(std::uint64_t position) {
  file_->clear();
  file_->seekg(static_cast<std::streamoff>(position));
  buffer_.clear();
  buffer_offset_ = position;
  begin_ = 0;
  problem_.clear();
  has_ended_ = false;
  entries_ = 0;
  sought_ = position;
}

// How many entries lie before that position is not known after a seek, so their count has to say where it begins.
std::string SessionReader::describe_count() const {
  return sought_ ? fmt::format("{} entries from byte {}", entries_, *sought_) : fmt::format("{} entries", entries_);
}

bool SessionReader::next(SessionEntry& entry) {
  while (problem_.empty()) {
    const SessionCodec::Read read = codec_.read(std::string_view(buffer_).substr(begin_), entry);
    if (read.status == SessionCodec::Status::cut && (refill() || !problem_.empty())) continue;
    if (read.status == SessionCodec::Status::cut && begin_ == buffer_.size()) {
      if (!header_.has_end || has_ended_) return false;
      problem_ = fmt::format("{}: has no end after {}: io_node still records, was killed, or its disk was full; all of them were read",
                             path_.string(), describe_count());
      return false;
    }
    if (read.status == SessionCodec::Status::cut || read.status == SessionCodec::Status::damaged) {
      problem_ =
          fmt::format("{}: {} after {}, at byte {}; the entries before it were read", path_.string(),
                      read.status == SessionCodec::Status::cut ? "is cut short" : "is damaged", describe_count(), buffer_offset_ + begin_);
      return false;
    }
    begin_ += read.bytes;
    if (read.status == SessionCodec::Status::unknown) continue;
    has_ended_ = entry.kind == SessionEntry::Kind::end;
    if (has_ended_) continue;
    ++entries_;
    return true;
  }
  return false;
}

}  // namespace hapton
