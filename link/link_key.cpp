#include "link/link_key.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <system_error>

#include "link/key_schedule.h"
#include "link/udp_endpoint.h"

namespace hapton {
namespace {

constexpr mode_t kMode = S_IRUSR | S_IWUSR;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

// How systemd gives a credential to a service that is not root: root owns the file, and its access list shows as group read permission.
bool is_systemd_credential(const struct stat& file_stat) {
  return file_stat.st_uid == 0 && file_stat.st_gid == 0 && (file_stat.st_mode & 07777) == (S_IRUSR | S_IRGRP);
}

// "hapton-vision", NUL-padded.
using Label = std::array<char, kKeyFileBytes - LinkKey::kBytes>;
constexpr std::string_view kLabelBegin = "hapton-";

struct KeyFile {
  Label label = {};
  LinkKey::Bytes bytes = {};

  KeyFile() = default;
  KeyFile(KeyRole role, const LinkKey::Bytes& key) : bytes(key) {
    std::copy(kLabelBegin.begin(), kLabelBegin.end(), label.begin());
    const std::string_view name = to_string(role);
    std::copy(name.begin(), name.end(), label.begin() + kLabelBegin.size());
  }
  ~KeyFile() { sodium_memzero(bytes.data(), bytes.size()); }
  KeyFile(const KeyFile&) = default;
  KeyFile& operator=(const KeyFile&) = default;

  // None: the label is not one of Hapton's.
  std::optional<KeyRole> role() const {
    for (std::uint8_t byte = static_cast<std::uint8_t>(KeyRole::master); byte <= kLastKeyRole; ++byte) {
      if (label == KeyFile(static_cast<KeyRole>(byte), {}).label) return static_cast<KeyRole>(byte);
    }
    return std::nullopt;
  }
};
static_assert(sizeof(KeyFile) == kKeyFileBytes);

// Anyone who may write to a folder on a file's path can replace the file; in a folder with the sticky bit (/tmp) only the file's owner can.
Result<void> check_folders_above(const std::filesystem::path& path, const std::filesystem::path& named) {
  for (std::filesystem::path folder = path.parent_path(); !folder.empty(); folder = folder.parent_path()) {
    struct stat file_stat = {};
    if (stat(folder.c_str(), &file_stat) == 0 && (file_stat.st_mode & S_IWOTH) != 0 && (file_stat.st_mode & S_ISVTX) == 0) {
      return fail("{}: anyone can replace the key, as the folder {} is writable by all (mode {:04o}); fix it with: chmod o-w {}",
                  named.string(), folder.string(), file_stat.st_mode & 07777, folder.string());
    }
    if (folder == folder.root_path()) break;
  }
  return {};
}

// Checks the path as named, where a link could be replaced, and the path that it resolves to.
Result<void> check_folders(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path named = std::filesystem::absolute(path, error);
  if (error) return {};  // the file cannot be opened then, and that error says more
  if (const auto good = check_folders_above(named, path); !good) return good;
  const std::filesystem::path real = std::filesystem::weakly_canonical(path, error);
  return error ? Result<void>() : check_folders_above(real, path);
}

Result<void> check_size(const std::filesystem::path& path, off_t bytes) {
  if (bytes == static_cast<off_t>(kKeyFileBytes)) return {};
  if (bytes == static_cast<off_t>(LinkKey::kBytes)) {
    return fail(
        "{}: is a key of an older Hapton, which had one key for all nodes; now the hub has a master key (hapton keygen FILE), and every "
        "other host the key of its role (hapton keygen --role vision --master FILE vision.key); remove this key and make those",
        path.string());
  }
  return fail("{}: has {} bytes, but a key file has {}; make one with: hapton keygen FILE", path.string(), bytes, kKeyFileBytes);
}

Result<void> check(const std::filesystem::path& path, const struct stat& file_stat) {
  if (!S_ISREG(file_stat.st_mode)) return fail("{}: is not a regular file; make a key with: hapton keygen FILE", path.string());
  const bool is_credential = is_systemd_credential(file_stat);
  if (file_stat.st_uid != geteuid() && !is_credential) {
    return fail("{}: belongs to user {}, and this program runs as user {}; a key file must belong to its user: chown {} {}", path.string(),
                file_stat.st_uid, geteuid(), geteuid(), path.string());
  }
  if ((file_stat.st_mode & (S_IRWXG | S_IRWXO)) != 0 && !is_credential) {
    return fail("{}: is readable by other users (mode {:04o}); fix it with: chmod 600 {}", path.string(), file_stat.st_mode & 07777,
                path.string());
  }
  return check_size(path, file_stat.st_size);
}

// Returns 0, or the errno of what failed; after a failure the file does not exist, unless it existed before.
int write_new_file(const std::filesystem::path& path, const KeyFile& key) {
  const Descriptor file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode));
  if (file.number() < 0) return errno;
  const ssize_t written = write(file.number(), &key, sizeof key);
  int error = written == static_cast<ssize_t>(sizeof key) ? 0 : written < 0 ? errno : ENOSPC;
  // Sets the mode whatever the umask is.
  if (error == 0 && (fchmod(file.number(), kMode) != 0 || fsync(file.number()) != 0)) error = errno;
  if (error != 0) unlink(path.c_str());
  return error;
}

tl::unexpected<Error> fail_to_make(const std::filesystem::path& path, int error) {
  return fail("{}: the key cannot be written: {}; choose a folder that you own", path.string(), std::strerror(error));
}

tl::unexpected<Error> fail_to_share(const std::filesystem::path& path, int error) {
  return fail("{}: this user's key cannot be written: {}; make one elsewhere with hapton keygen FILE, and give --key FILE to every node",
              path.string(), std::strerror(error));
}

KeyFile make_master() {
  KeyFile file(KeyRole::master, {});
  randombytes_buf(file.bytes.data(), file.bytes.size());
  return file;
}

Result<KeyFile> read_any_key_file(const std::filesystem::path& path) {
  if (const auto started = seal::start_crypto(); !started) return tl::unexpected(started.error());
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) {
    if (errno == EACCES) return fail("{}: no permission to read the key; ask its owner for a copy", path.string());
    return fail("{}: the key cannot be read: {}; make one with: hapton keygen {}", path.string(), std::strerror(errno), path.string());
  }
  struct stat file_stat = {};
  if (fstat(file.number(), &file_stat) != 0) return fail("{}: the key cannot be read: {}", path.string(), std::strerror(errno));
  if (const auto good = check(path, file_stat); !good) return tl::unexpected(good.error());
  if (const auto good = check_folders(path); !good) return tl::unexpected(good.error());
  KeyFile key;
  if (read(file.number(), &key, sizeof key) != static_cast<ssize_t>(sizeof key)) {
    return fail("{}: the key cannot be read completely; make one with: hapton keygen FILE", path.string());
  }
  if (!key.role()) return fail("{}: is not a Hapton key file; make one with: hapton keygen FILE", path.string());
  if (std::all_of(key.bytes.begin(), key.bytes.end(), [&](std::uint8_t byte) { return byte == key.bytes[0]; })) {
    return fail("{}: all bytes of the key are the same, so it is not secret; make one with: hapton keygen FILE", path.string());
  }
  return key;
}

Result<void> make_any_key_file(const std::filesystem::path& path, const KeyFile& key) {
  if (const auto good = check_folders(path); !good) return good;
  const int error = write_new_file(path, key);
  if (error == EEXIST) return fail("{}: already exists and was not changed; name another file, or remove this one first", path.string());
  if (error != 0) return fail_to_make(path, error);
  return {};
}

Result<std::string> find_key_path(const std::string& key_file, const Address& hub) {
  if (!key_file.empty() || is_loopback(hub)) return key_file;
  return fail(
      "{} reaches beyond this machine, where every node needs a key; make a master key for the hub with hapton keygen FILE, one for each "
      "role with hapton keygen --role ROLE --master FILE, and give --key FILE to every node",
      to_string(hub));
}

}  // namespace

RoleKey::RoleKey(const LinkKey& master, KeyRole role) : bytes_(seal::derive_role_key(master, role)), role_(role) {}
RoleKey::~RoleKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

LinkKey::~LinkKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

LinkKey LinkKey::make_random() { return LinkKey(make_master().bytes); }

Result<LinkKey> read_key_file(const std::filesystem::path& path) {
  const auto file = read_any_key_file(path);
  if (!file) return tl::unexpected(file.error());
  if (*file->role() == KeyRole::master) return LinkKey(file->bytes);
  return fail("{}: is the key of role {}, and the hub needs the master key that it was derived from", path.string(),
              to_string(*file->role()));
}

Result<RoleKey> read_role_key_file(const std::filesystem::path& path, KeyRole role) {
  const auto file = read_any_key_file(path);
  if (!file) return tl::unexpected(file.error());
  const KeyRole found = *file->role();
  if (found == KeyRole::master) return RoleKey(LinkKey(file->bytes), role);
  if (found == role || (found == KeyRole::operator_role && role == KeyRole::tool)) return RoleKey(file->bytes, found);
  return fail(
      "{}: is the key of role {}, and this needs that of role {}; make it on the hub's host with: hapton keygen --role {} --master "
      "MASTER FILE",
      path.string(), to_string(found), to_string(role), to_string(role));
}

Result<void> make_key_file(const std::filesystem::path& path) {
  if (const auto started = seal::start_crypto(); !started) return tl::unexpected(started.error());
  return make_any_key_file(path, make_master());
}

Result<void> make_role_key_file(const std::filesystem::path& path, const LinkKey& master, KeyRole role) {
  return make_any_key_file(path, KeyFile(role, RoleKey(master, role).bytes()));
}

Result<std::filesystem::path> find_shared_key_folder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value == nullptr ? "" : value);
  };
  if (const auto runtime = variable("XDG_RUNTIME_DIR"); runtime.is_absolute()) return runtime / "hapton";
  if (const auto home = variable("HOME"); home.is_absolute()) return home / ".config" / "hapton";
  return fail(
      "no place for a key of this user: neither XDG_RUNTIME_DIR nor HOME is set; make one with hapton keygen FILE, and give --key FILE");
}

Result<LinkKey> find_or_make_shared_key(const std::filesystem::path& folder) {
  if (const auto started = seal::start_crypto(); !started) return tl::unexpected(started.error());
  const std::filesystem::path path = folder / "master";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    const bool is_new = std::filesystem::create_directories(folder, error);
    if (is_new) std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
    if (error) return fail_to_share(path, error.value());
    // Writes a temporary file and then links it to the final name, which succeeds only once: no process reads half a key, and all
    // processes read the same key.
    const std::filesystem::path temporary =
        folder / fmt::format("master.{}.{:016x}", getpid(), (std::uint64_t{randombytes_random()} << 32) | randombytes_random());
    if (const int failure = write_new_file(temporary, make_master()); failure != 0) return fail_to_share(temporary, failure);
    const bool has_key_file = link(temporary.c_str(), path.c_str()) == 0 || errno == EEXIST;
    const int failure = errno;
    unlink(temporary.c_str());
    if (!has_key_file) return fail_to_share(path, failure);
  }
  return read_key_file(path);
}

Result<LinkKey> find_link_key(const std::string& key_file, const Address& hub) {
  const auto path = find_key_path(key_file, hub);
  if (!path) return tl::unexpected(path.error());
  if (!path->empty()) return read_key_file(*path);
  const auto folder = find_shared_key_folder();
  if (!folder) return tl::unexpected(folder.error());
  return find_or_make_shared_key(*folder);
}

Result<RoleKey> find_role_key(const std::string& key_file, const Address& hub, KeyRole role) {
  if (!key_file.empty()) return read_role_key_file(key_file, role);
  const auto master = find_link_key(key_file, hub);
  if (!master) return tl::unexpected(master.error());
  return RoleKey(*master, role);
}

}  // namespace hapton
