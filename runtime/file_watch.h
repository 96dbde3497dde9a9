#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace hapton {

// Notices that a file was saved: by its time and size, whenever it is asked to check. RT: no. Threads: one.
class FileWatch {
 public:
  // The file as it is now is known.
  explicit FileWatch(std::filesystem::path path);

  enum class State : std::uint8_t {
    unchanged,
    waiting,  // it has just changed, and may be being written
    changed,  // it has changed and was the same for two checks; reported until accept()
    gone      // there was no file for two checks; reported once, as editors remove a file for a moment
  };
  State check();

  // The file as the last check found it is known from now on. Pre: that check was `changed`.
  void accept();

  // There was no file for two checks, and none since.
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
  Stamp known_;
  std::optional<Stamp> seen_;  // changed at the check before
  int checks_without_file_ = 0;
};

}  // namespace hapton
