#include "runtime/part_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace hapton {
namespace {

bool is_in_dev(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.parent_path();
  return folder == "/dev" || folder == "/dev/fd";
}

// The file to which a symbolic link leads, even if it does not exist yet, so that the link is kept. Any other path is unchanged.
std::filesystem::path follow_links(const std::filesystem::path& link) {
  constexpr int kMaxLinks = 40;  // as in the kernel
  std::error_code error;
  std::filesystem::path path = link;
  for (int n = 0; n < kMaxLinks && std::filesystem::is_symlink(path, error); ++n) {
    path = path.parent_path() / std::filesystem::read_symlink(path, error);
  }
  return std::filesystem::is_symlink(path, error) ? link : path;
}

}  // namespace

PartPath::PartPath(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code error;
  target_ = path_;
  part_ = path_;
  // /dev/stdout and /dev/fd/N are written directly, even if they lead to a regular file.
  if (is_in_dev(path_)) return;
  const auto status = std::filesystem::status(path_, error);
  const bool is_other =
      std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) && !std::filesystem::is_directory(status);
  if (is_other) return;
  target_ = part_ = follow_links(path_);
  if (is_in_dev(target_)) return;
  part_ += fmt::format(".{}.part", getpid());
  is_pending_ = true;
}

PartPath::PartPath(PartPath&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      part_(std::move(other.part_)),
      is_pending_(std::exchange(other.is_pending_, false)) {}

PartPath& PartPath::operator=(PartPath&& other) noexcept {
  discard();
  path_ = std::move(other.path_);
  target_ = std::move(other.target_);
  part_ = std::move(other.part_);
  is_pending_ = std::exchange(other.is_pending_, false);
  return *this;
}

void PartPath::discard() noexcept {
  std::error_code error;
  if (std::exchange(is_pending_, false)) std::filesystem::remove(part_, error);
}

Result<void> PartPath::keep() {
  if (!is_pending_) return {};
  std::error_code error;
  std::filesystem::rename(part_, target_, error);
  if (!error) {
    is_pending_ = false;
    return {};
  }
  discard();
  return fail("cannot write {}: {}; check the permissions and the free space of its folder, or choose another one", path_.string(),
              error.message());
}

Result<PartFile> PartFile::open(const std::filesystem::path& path) {
  PartPath part(path);
  File file(open_file_for(part.part(), FileReaders::everyone), &std::fclose);
  if (!file) return fail("{}: cannot be written: {}", path.string(), std::strerror(errno));
  return PartFile(std::move(part), std::move(file));
}

void PartFile::check(bool is_written) noexcept {
  if (!is_written && error_ == 0) error_ = errno != 0 ? errno : EIO;
}

Result<void> PartFile::close() {
  if (file_) check(std::fflush(file_.get()) == 0);
  if (file_) check(std::fclose(file_.release()) == 0);
  if (error_ == 0) return {};
  const std::filesystem::path path = path_.path();
  path_ = PartPath();
  return fail("{}: cannot be written: {}", path.string(), std::strerror(error_));
}

}  // namespace hapton
