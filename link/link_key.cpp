#include "link/link_key.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
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

// How systemd hands a credential to a service that is not root: root's own, with an access list that shows as the group's right to read.
bool is_systemd_credential(const struct stat& found) {
  return found.st_uid == 0 && found.st_gid == 0 && (found.st_mode & 07777) == (S_IRUSR | S_IRGRP);
}

Result<void> check(const std::filesystem::path& path, const struct stat& found) {
  if (!S_ISREG(found.st_mode)) return fail("{}: is no regular file; make a key with: hapton keygen FILE", path.string());
  const bool is_credential = is_systemd_credential(found);
  if (found.st_uid != geteuid() && !is_credential) {
    return fail("{}: belongs to user {}, and this program runs as user {}; a key must be its user's own: chown {} {}", path.string(),
                found.st_uid, geteuid(), geteuid(), path.string());
  }
  if ((found.st_mode & (S_IRWXG | S_IRWXO)) != 0 && !is_credential) {
    return fail("{}: is open to other users (mode {:04o}); close it with: chmod 600 {}", path.string(), found.st_mode & 07777,
                path.string());
  }
  if (found.st_size != static_cast<off_t>(LinkKey::kBytes)) {
    return fail("{}: holds {} bytes where a key has {}; make one with: hapton keygen FILE", path.string(), found.st_size, LinkKey::kBytes);
  }
  return {};
}

// 0, or the errno of what failed; then there is no such file afterwards, unless it was there before.
int write_new_file(const std::filesystem::path& path, const LinkKey& key) {
  const Descriptor file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode));
  if (file.number() < 0) return errno;
  const ssize_t written = write(file.number(), key.bytes().data(), LinkKey::kBytes);
  int error = written == static_cast<ssize_t>(LinkKey::kBytes) ? 0 : written < 0 ? errno : ENOSPC;
  // Whatever the umask is.
  if (error == 0 && (fchmod(file.number(), kMode) != 0 || fsync(file.number()) != 0)) error = errno;
  if (error != 0) unlink(path.c_str());
  return error;
}

tl::unexpected<Error> fail_to_make(const std::filesystem::path& path, int error) {
  return fail("{}: the key cannot be written: {}; name a place that is yours", path.string(), std::strerror(error));
}

tl::unexpected<Error> fail_to_share(const std::filesystem::path& path, int error) {
  return fail("{}: this user's key cannot be written: {}; make one elsewhere with hapton keygen FILE, and give --key FILE to every node",
              path.string(), std::strerror(error));
}

}  // namespace

LinkKey::~LinkKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

LinkKey LinkKey::make_random() {
  Bytes bytes;
  randombytes_buf(bytes.data(), bytes.size());
  LinkKey key(bytes);
  sodium_memzero(bytes.data(), bytes.size());
  return key;
}

Result<LinkKey> read_key_file(const std::filesystem::path& path) {
  if (const auto started = seal::start_crypto(); !started) return tl::unexpected(started.error());
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) {
    if (errno == EACCES) return fail("{}: this user may not read the key; ask its owner for a copy of your own", path.string());
    return fail("{}: the key cannot be read: {}; make one with: hapton keygen {}", path.string(), std::strerror(errno), path.string());
  }
  struct stat found = {};
  if (fstat(file.number(), &found) != 0) return fail("{}: the key cannot be read: {}", path.string(), std::strerror(errno));
  if (const auto good = check(path, found); !good) return tl::unexpected(good.error());
  LinkKey::Bytes bytes = {};
  if (read(file.number(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
    return fail("{}: the key cannot be read whole; make one with: hapton keygen FILE", path.string());
  }
  if (sodium_is_zero(bytes.data(), bytes.size()) != 0) {
    return fail("{}: is all zeros, which is no key; make one with: hapton keygen FILE", path.string());
  }
  LinkKey key(bytes);
  sodium_memzero(bytes.data(), bytes.size());
  return key;
}

Result<void> make_key_file(const std::filesystem::path& path) {
  if (const auto started = seal::start_crypto(); !started) return tl::unexpected(started.error());
  const int error = write_new_file(path, LinkKey::make_random());
  if (error == EEXIST) return fail("{}: is there already and stays as it is; name another file, or remove this one first", path.string());
  if (error != 0) return fail_to_make(path, error);
  return {};
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
  const std::filesystem::path path = folder / "key";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    const bool is_new = std::filesystem::create_directories(folder, error);
    if (is_new) std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
    if (error) return fail_to_share(path, error.value());
    // Written whole beside, then given its name, which only the first of several can do: nobody reads half a key, and all read one.
    const std::filesystem::path beside =
        folder / fmt::format("key.{}.{:016x}", getpid(), (std::uint64_t{randombytes_random()} << 32) | randombytes_random());
    if (const int failure = write_new_file(beside, LinkKey::make_random()); failure != 0) return fail_to_share(beside, failure);
    const bool named = link(beside.c_str(), path.c_str()) == 0 || errno == EEXIST;
    const int failure = errno;
    unlink(beside.c_str());
    if (!named) return fail_to_share(path, failure);
  }
  return read_key_file(path);
}

bool is_loopback(const Address& address) {
  constexpr std::array<std::uint8_t, 13> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127};
  constexpr std::array<std::uint8_t, 16> kV6 = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  return std::equal(kMapped.begin(), kMapped.end(), address.ip.begin()) || address.ip == kV6;
}

Result<LinkKey> find_link_key(const std::string& key_file, const Address& hub) {
  if (!key_file.empty()) return read_key_file(key_file);
  if (!is_loopback(hub)) {
    return fail(
        "{} reaches beyond this machine, where everyone needs the same key; make one with hapton keygen FILE, and give --key FILE to every "
        "node",
        to_string(hub));
  }
  const auto folder = find_shared_key_folder();
  if (!folder) return tl::unexpected(folder.error());
  return find_or_make_shared_key(*folder);
}

}  // namespace hapton
