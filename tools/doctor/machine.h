#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "link/address.h"

namespace hapton::doctor {

// The user of this process, as the kernel sees it.
struct User {
  static constexpr int kSysNice = 23;  // bits of capabilities(7)
  static constexpr int kIpcLock = 14;

  uid_t uid = 0;
  std::vector<gid_t> groups;  // the first is its own
  std::uint64_t capabilities = 0;
  std::string name;  // "ada"; its number if /etc/passwd does not have it

  bool has_capability(int bit) const { return ((capabilities >> bit) & 1) != 0; }
  bool is_in(gid_t group) const;
};

struct FileFacts {
  bool is_regular = false;
  uid_t uid = 0;
  gid_t gid = 0;
  mode_t mode = 0;  // the rights alone
  std::uint64_t bytes = 0;
};

struct LibraryFailure {
  std::string file;
  std::string error;  // the loader's message
  std::string hint;
};
struct LibraryReply {
  std::string file;  // the file loaded; empty: none
  std::vector<LibraryFailure> failures;
  std::string crash;  // loading it ended the process: how
};

struct DisplayReply {
  std::string error;     // no connection, no OpenGL: why; empty: all is known
  std::string renderer;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string version;
  bool is_direct = false;
  bool has_stereo = false;  // a quad-buffer stereo visual
};

struct HubReply {
  std::string error;   // why there is no report
  std::string report;  // report.json
};

// The machine as the doctor sees it: files below a root ("/" for the real one), and queries that no file answers (a vendor's library, the
// display, the hub). A test provides its own root and functions; a query without a function is skipped. RT: no. Threads: one.
class Machine {
 public:
  struct Questions {
    std::function<LibraryReply(std::string_view library)> library;  // by KnownVendorLibrary::name
    std::function<DisplayReply()> display;
    std::function<HubReply()> hub;
  };
  struct Settings {
    int hub_port = kDefaultHubPort;
    std::string key_file;  // empty: the user's own
  };

  // Pre: root is absolute, or relative to a working directory that stays.
  Machine(std::filesystem::path root, Questions questions, Settings settings);

  const User& user() const { return user_; }
  const Questions& questions() const { return questions_; }
  const Settings& settings() const { return settings_; }

  // Paths are as on the machine itself ("/proc/self/limits"). Nothing there, or not readable: none.
  std::optional<std::string> read(std::string_view path) const;  // without blanks at its end, 1 MiB at most
  std::string read_bytes(std::string_view path) const;           // as they are; empty: nothing to be read
  std::optional<double> read_number(std::string_view path) const;
  std::vector<std::string> list(std::string_view folder) const;  // names, sorted
  bool exists(std::string_view path) const;
  std::optional<FileFacts> facts(std::string_view path) const;
  std::string link_name(std::string_view path) const;  // last part of where a symbolic link leads; empty: no link
  std::string real_path(std::string_view path) const;  // links resolved, still as on the machine itself; empty: nothing there
  // Reads and writes, for this user, without opening it.
  bool may_use(std::string_view path) const;
  bool may_read(std::string_view path) const;

  std::string environment(std::string_view name) const;  // empty: not set
  // Of the first process of that name; none: it does not run.
  std::optional<pid_t> find_process(std::string_view name) const;
  // The id of a group, and whether this user belongs to it, by /etc/group (which takes effect at the next login) or in this session; none:
  // no such group.
  struct Group {
    gid_t gid = 0;
    bool has_user = false;
  };
  std::optional<Group> find_group(std::string_view name) const;

 private:
  std::filesystem::path below(std::string_view path) const;
  bool may(std::string_view path, bool writes) const;
  User read_user() const;

  std::filesystem::path root_;
  Questions questions_;
  Settings settings_;
  User user_;
};

// The lines of a text.
std::vector<std::string_view> split_lines(std::string_view text);
// The words of a line.
std::vector<std::string_view> split_words(std::string_view line);
// Of "Uid:\t0\t0" and the like: what follows the key, without blanks around it; empty: no such line.
std::string_view find_field(std::string_view text, std::string_view key);

}  // namespace hapton::doctor
