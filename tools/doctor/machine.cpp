#include "tools/doctor/machine.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <system_error>
#include <utility>

namespace hapton::doctor {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;  // largest part of a file that is read; a free choice
constexpr std::string_view kBlanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

template <class Number>
std::optional<Number> number_of(std::string_view text, int base = 10) {
  Number number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (error != std::errc() || end == text.data()) return std::nullopt;
  return number;
}

bool is_number(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == text.npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// Opens only regular files, since opening a pipe would wait.
bool is_readable_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && std::ifstream(path).is_open();
}

}  // namespace

bool User::is_in(gid_t group) const { return std::find(groups.begin(), groups.end(), group) != groups.end(); }

std::vector<std::string_view> split_lines(std::string_view text) { return split(text, '\n'); }

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

std::string_view find_field(std::string_view text, std::string_view key) {
  for (const std::string_view line : split_lines(text)) {
    if (line.starts_with(key)) return trimmed(line.substr(key.size()));
  }
  return {};
}

Machine::Machine(std::filesystem::path root, Queries queries, Settings settings)
    : root_(std::move(root)), queries_(std::move(queries)), settings_(std::move(settings)), user_(read_user()) {}

std::filesystem::path Machine::full_path(std::string_view path) const {
  path.remove_prefix(std::min(path.find_first_not_of('/'), path.size()));
  return root_ / path;
}

std::string Machine::read_bytes(std::string_view path) const {
  if (!is_readable_file(full_path(path))) return {};
  std::ifstream file(full_path(path), std::ios::binary);
  std::string text;
  char block[4096];
  while (file && text.size() < kMaxBytes) {
    file.read(block, sizeof block);
    text.append(block, static_cast<std::size_t>(file.gcount()));
  }
  return text;
}

std::optional<std::string> Machine::read(std::string_view path) const {
  if (!is_readable_file(full_path(path))) return std::nullopt;
  std::string text = read_bytes(path);
  text.resize(text.find_last_not_of(kBlanks) + 1);
  return text;
}

std::optional<double> Machine::read_number(std::string_view path) const {
  const auto text = read(path);
  if (!text) return std::nullopt;
  const char* begin = text->c_str();
  char* end = nullptr;
  const double number = std::strtod(begin, &end);
  if (end == begin) return std::nullopt;
  return number;
}

std::vector<std::string> Machine::list(std::string_view folder) const {
  std::vector<std::string> names;
  std::error_code error;
  for (auto entry = std::filesystem::directory_iterator(full_path(folder), error); !error && entry != std::filesystem::directory_iterator();
       entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool Machine::exists(std::string_view path) const {
  std::error_code error;
  return std::filesystem::exists(full_path(path), error);
}

std::optional<FileFacts> Machine::facts(std::string_view path) const {
  struct stat status = {};
  if (::stat(full_path(path).c_str(), &status) != 0) return std::nullopt;
  return FileFacts{.is_regular = S_ISREG(status.st_mode),
                   .uid = status.st_uid,
                   .gid = status.st_gid,
                   .mode = static_cast<mode_t>(status.st_mode & 07777),
                   .bytes = static_cast<std::uint64_t>(status.st_size)};
}

std::string Machine::link_name(std::string_view path) const {
  std::error_code error;
  const auto target = std::filesystem::read_symlink(full_path(path), error);
  return error ? std::string() : target.filename().string();
}

std::string Machine::real_path(std::string_view path) const {
  std::error_code error;
  const auto target = std::filesystem::canonical(full_path(path), error);
  if (error) return {};
  const auto root = std::filesystem::canonical(root_, error);
  if (error) return {};
  return "/" + target.lexically_relative(root).string();
}

// On the real machine the kernel decides, since it knows access lists; below another root the mode bits of the files decide.
bool Machine::has_access(std::string_view path, bool writes) const {
  if (root_ == "/") return ::faccessat(AT_FDCWD, full_path(path).c_str(), writes ? R_OK | W_OK : R_OK, AT_EACCESS) == 0;
  const auto file = facts(path);
  if (!file) return false;
  if (user_.uid == 0) return true;
  const mode_t needed_bits = writes ? 06 : 04;
  const int shift = file->uid == user_.uid ? 6 : user_.is_in(file->gid) ? 3 : 0;
  return ((file->mode >> shift) & needed_bits) == needed_bits;
}

bool Machine::may_use(std::string_view path) const { return has_access(path, true); }
bool Machine::may_read(std::string_view path) const { return has_access(path, false); }

std::string Machine::environment(std::string_view name) const {
  const auto text = read("/proc/self/environ");
  if (!text) return {};
  for (const std::string_view entry : split(*text, '\0')) {
    if (entry.size() > name.size() && entry.starts_with(name) && entry[name.size()] == '=')
      return std::string(entry.substr(name.size() + 1));
  }
  return {};
}

std::optional<pid_t> Machine::find_process(std::string_view name) const {
  for (const std::string& pid : list("/proc")) {
    if (!is_number(pid)) continue;
    if (const auto comm = read("/proc/" + pid + "/comm"); comm && *comm == name) return number_of<pid_t>(pid);
  }
  return std::nullopt;
}

std::optional<Machine::Group> Machine::find_group(std::string_view name) const {
  const std::string text = read("/etc/group").value_or("");
  for (const std::string_view line : split_lines(text)) {
    const auto fields = split(line, ':');
    if (fields.size() < 4 || fields[0] != name) continue;
    const auto members = split(fields[3], ',');
    const auto gid = number_of<gid_t>(fields[2]);
    if (!gid) continue;
    return Group{*gid, std::find(members.begin(), members.end(), user_.name) != members.end() || user_.is_in(*gid)};
  }
  return std::nullopt;
}

User Machine::read_user() const {
  User user{.uid = ::geteuid(), .groups = {}, .capabilities = 0, .name = {}};
  const std::string status = read("/proc/self/status").value_or("");
  const auto uids = split_words(find_field(status, "Uid:"));
  const auto gids = split_words(find_field(status, "Gid:"));
  // The effective ids: each line has the real, effective, saved and file-system id, in this order.
  if (uids.size() > 1) user.uid = number_of<uid_t>(uids[1]).value_or(0);
  if (gids.size() > 1) user.groups.push_back(number_of<gid_t>(gids[1]).value_or(0));
  for (const std::string_view group : split_words(find_field(status, "Groups:")))
    user.groups.push_back(number_of<gid_t>(group).value_or(0));
  user.capabilities = number_of<std::uint64_t>(find_field(status, "CapEff:"), 16).value_or(0);
  user.name = user.uid == 0 ? "root" : std::to_string(user.uid);
  const std::string users = read("/etc/passwd").value_or("");
  for (const std::string_view line : split_lines(users)) {
    const auto fields = split(line, ':');
    if (fields.size() > 2 && number_of<uid_t>(fields[2]) == user.uid) {
      user.name = std::string(fields[0]);
      break;
    }
  }
  return user;
}

}  // namespace hapton::doctor
