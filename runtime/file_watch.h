#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace hapton {

// Notices that a file was saved: by its time and size, whenever it is asked to check. RT: no. Threads: one.
class FileWatch {
 public:
  // Takes the present state of the file as known: only later changes are reported.
  explicit FileWatch(std::filesystem::path path);

  enum class State : std::uint8_t {
    unchanged,
    waiting,  // the file has just changed, and may not be completely written yet
    changed,  // the file has changed and was the same for two checks; reported until accept()
    gone      // there was no file for two checks; reported once, as editors remove a file for a moment
  };
  State check();

  // Takes the state that the last check found as known. Pre: that check returned `changed`.
  void accept();

  // At least the last two checks found no file.
  bool is_gone() const { return checks_without_file_ >= 2; }

 private:
  struct Stamp {
    std::filesystem::file_time_type time = {};
    std::uintmax_t bytes = 0;
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  // None: there is no file now.
  std::optional<Stamp> stamp_of_file() const;

  std::filesystem::path path_;
  Stamp accepted_stamp_;
  std::optional<Stamp> changed_stamp_;  // the file at the last check, if it had changed
  int checks_without_file_ = 0;
};

}  // namespace hapton
