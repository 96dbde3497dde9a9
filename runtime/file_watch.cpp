#include "runtime/file_watch.h"

#include <system_error>
#include <utility>

namespace hapton {

FileWatch::FileWatch(std::filesystem::path path) : path_(std::move(path)) { accepted_stamp_ = stamp_of_file().value_or(Stamp()); }

std::optional<FileWatch::Stamp> FileWatch::stamp_of_file() const {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(path_, error);
  if (error) return std::nullopt;
  const auto bytes = std::filesystem::file_size(path_, error);
  return error ? std::nullopt : std::optional(Stamp{time, bytes});
}

FileWatch::State FileWatch::check() {
  const std::optional<Stamp> stamp = stamp_of_file();
  if (!stamp) {
    changed_stamp_.reset();
    return ++checks_without_file_ == 2 ? State::gone : State::unchanged;
  }
  checks_without_file_ = 0;
  if (*stamp == accepted_stamp_) {
    changed_stamp_.reset();
    return State::unchanged;
  }
  if (std::exchange(changed_stamp_, stamp) != stamp) return State::waiting;
  return State::changed;
}

void FileWatch::accept() {
  accepted_stamp_ = changed_stamp_.value_or(accepted_stamp_);
  changed_stamp_.reset();
}

}  // namespace hapton
