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

// The effective user of this process.
struct User {
  static constexpr int kSysNice = 23;  // bits of capabilities(7)
  static constexpr int kIpcLock = 14;

  uid_t uid = 0;
  std::vector<gid_t> groups;  // the first is the primary group
  std::uint64_t capabilities = 0;
  std::string name;  // "ada"; the uid as text if /etc/passwd does not have it, "root" for 0

  bool has_capability(int bit) const { return ((capabilities >> bit) & 1) != 0; }
  bool is_in(gid_t group) const;
};

struct FileFacts {
  bool is_regular = false;
  uid_t uid = 0;
  gid_t gid = 0;
  mode_t mode = 0;  // the permission bits only
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
  std::string crash;  // how the library ended or hung the child process; empty: it did not
};

struct DisplayReply {
  std::string error;     // why there is no connection or no OpenGL; empty: all members below are set
  std::string renderer;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string version;
  bool is_direct = false;
  bool has_stereo = false;  // there is a visual with quad-buffer stereo
};

struct HubReply {
  std::string error;   // why there is no report; empty: there is one
  std::string report;  // the text of report.json
};

// The machine as the doctor sees it: the files below a root folder ("/" for the real machine), and queries that no file answers (a vendor
// library, the display, the hub). A test gives its own root and functions; a query without a function is skipped. RT: no. Threads: one.
class Machine {
 public:
  struct Queries {
    std::function<LibraryReply(std::string_view library)> library;  // library: a KnownVendorLibrary::name
    std::function<DisplayReply()> display;
    std::function<HubReply()> hub;
  };
  struct Settings {
    int hub_port = kDefaultHubPort;
    std::string key_file;  // key given on the command line; empty: the user's own
  };

  // Pre: root is absolute, or the working directory of the process does not change.
  Machine(std::filesystem::path root, Queries queries, Settings settings);

  const User& user() const { return user_; }
  const Queries& queries() const { return queries_; }
  const Settings& settings() const { return settings_; }

  // Paths are those of the machine itself, without the root ("/proc/self/limits"). No such file, or it is not readable: none, or empty.
  std::optional<std::string> read(std::string_view path) const;  // the text without blanks at its end, 1 MiB at most
  std::string read_bytes(std::string_view path) const;           // the content unchanged, 1 MiB at most
  std::optional<double> read_number(std::string_view path) const;
  std::vector<std::string> list(std::string_view folder) const;  // the names in the folder, sorted
  bool exists(std::string_view path) const;
  std::optional<FileFacts> facts(std::string_view path) const;
  std::string link_name(std::string_view path) const;  // last component of a symbolic link's target; empty: not a link
  // With links resolved, without the root; empty: no such file. Pre: no link leads out of the root.
  std::string real_path(std::string_view path) const;
  // Whether this user may read and write the file, or read it; found without opening it.
  bool may_use(std::string_view path) const;
  bool may_read(std::string_view path) const;

  std::string environment(std::string_view name) const;  // empty: not set
  // The id of a process of that name; none: there is no such process.
  std::optional<pid_t> find_process(std::string_view name) const;
  // The id of a group, and whether this user belongs to it, either by /etc/group (in effect from the next login on) or in this session.
  // None: no such group.
  struct Group {
    gid_t gid = 0;
    bool has_user = false;
  };
  std::optional<Group> find_group(std::string_view name) const;

 private:
  std::filesystem::path full_path(std::string_view path) const;
  bool has_access(std::string_view path, bool writes) const;
  User read_user() const;

  std::filesystem::path root_;
  Queries queries_;
  Settings settings_;
  User user_;
};

// The lines of a text.
std::vector<std::string_view> split_lines(std::string_view text);
// The words of a line.
std::vector<std::string_view> split_words(std::string_view line);
// Finds the first line that begins with key ("Uid:\t0\t0"), and returns the rest of it without blanks around; empty: no such line.
std::string_view find_field(std::string_view text, std::string_view key);

}  // namespace hapton::doctor
