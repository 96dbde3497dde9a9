#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"
#include "link/key_role.h"
#include "link/role_key.h"

namespace hapton {

// The master key of a system, held by its hub: the key of every role is derived from it (role_key.h). Its holder can take every role. Wiped
// from memory on destruction.
class LinkKey {
 public:
  static constexpr std::size_t kBytes = 32;
  using Bytes = std::array<std::uint8_t, kBytes>;

  // Pre of every use: seal::start_crypto() succeeded; the functions below this class that return a key call it.
  explicit LinkKey(const Bytes& bytes) : bytes_(bytes) {}
  ~LinkKey();
  LinkKey(const LinkKey&) = default;
  LinkKey& operator=(const LinkKey&) = default;

  // A key from the system's random source. Pre: seal::start_crypto() succeeded.
  static LinkKey make_random();

  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

// A key file is 16 bytes that name the key ("hapton-master", "hapton-vision" ..., NUL-padded) and the 32 bytes of it: a regular file of the
// user who reads it, closed to everyone else (or a systemd credential), in a folder that not everyone may change. A key whose bytes are all
// the same is rejected.
// Error: one line that says what is wrong with the file and which command fixes it. RT: set-up only.
constexpr std::size_t kKeyFileBytes = 16 + LinkKey::kBytes;

// Reads the master key, for a hub.
Result<LinkKey> read_key_file(const std::filesystem::path& path);
// Reads the key of that role, for a node: the file's own, or derived from a master key in it. A tool may also have an operator's key.
Result<RoleKey> read_role_key_file(const std::filesystem::path& path, KeyRole role);

// Write a new key, mode 0600: a random master key, or a role's. Error: the file exists or cannot be written, or its folder is unsafe.
Result<void> make_key_file(const std::filesystem::path& path);
Result<void> make_role_key_file(const std::filesystem::path& path, const LinkKey& master, KeyRole role);

// The master key that the nodes of one user on one host share by default: FOLDER/master, created by the first of several concurrent
// calls.
Result<LinkKey> find_or_make_shared_key(const std::filesystem::path& folder);

// $XDG_RUNTIME_DIR/hapton, else ~/.config/hapton. Error: neither XDG_RUNTIME_DIR nor HOME is an absolute path.
Result<std::filesystem::path> find_shared_key_folder();

// The key for a hub at this address (where it listens, or where a node looks for it): from the named file; without one, the user's shared
// key on loopback, and an error beyond loopback. Error: see above.
Result<LinkKey> find_link_key(const std::string& key_file, const Address& hub);
Result<RoleKey> find_role_key(const std::string& key_file, const Address& hub, KeyRole role);

// What --key says in every program's --help.
constexpr const char* kKeyHelp =
    "Key file: the master key for the hub, the role's own for a node (hapton keygen); required when other hosts take part, default: "
    "this user's key";

}  // namespace hapton
