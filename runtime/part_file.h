#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/base/result.h"
#include "runtime/atomic_file.h"

namespace hapton {

// The name under which a file is written until it is complete: NAME.PID.part, in the same folder. keep() renames it; without keep() it is
// removed by the destructor, and an earlier file stays. A symbolic link stays, too: the file that it leads to is replaced. A file that is
// not regular, such as a pipe, and every path directly in /dev or /dev/fd is written directly, without a part. RT: no.
class PartPath {
 public:
  PartPath() = default;
  explicit PartPath(std::filesystem::path path);
  ~PartPath() { discard(); }
  PartPath(PartPath&& other) noexcept;
  PartPath& operator=(PartPath&& other) noexcept;

  // The path to write to.
  const std::filesystem::path& part() const noexcept { return part_; }
  // The file that keep() replaces: path(), or what a symbolic link at path() leads to.
  const std::filesystem::path& target() const noexcept { return target_; }
  // The path as given, for messages.
  const std::filesystem::path& path() const noexcept { return path_; }
  // Gives the part its final name. Pre: the part is closed. Error: one line with its final name; the part is removed.
  Result<void> keep();

 private:
  void discard() noexcept;

  std::filesystem::path path_;
  std::filesystem::path target_;  // path_, or what the symbolic link there leads to
  std::filesystem::path part_;
  bool is_pending_ = false;  // the part is to be removed
};

// A file that appears under its name when it is complete, or not at all. The first failure counts, also one that shows only when the file
// is closed. RT: no. Threads: one.
class PartFile {
 public:
  // Error: one line with the path and the reason.
  static Result<PartFile> open(const std::filesystem::path& path);

  // The stream to write to with stdio. Pre: not closed.
  std::FILE* get() const noexcept { return file_.get(); }
  // Notes a failure, with the present errno.
  void check(bool is_written) noexcept;
  bool is_good() const noexcept { return error_ == 0; }
  // Ends the writing; keep() then gives the file its name. Error: one line with the path and the reason; the part is removed.
  Result<void> close();
  // Pre: close() succeeded.
  Result<void> keep() { return path_.keep(); }

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  PartFile(PartPath path, File file) : path_(std::move(path)), file_(std::move(file)) {}

  PartPath path_;
  File file_;  // closed before the part is removed
  int error_ = 0;
};

}  // namespace hapton
