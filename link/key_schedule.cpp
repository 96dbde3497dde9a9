#include "link/key_schedule.h"

#include <sodium.h>

#include <algorithm>
#include <string_view>

#include "link/codec.h"

namespace hapton::seal {
namespace {

constexpr std::string_view kRoleLabel = "hapton role ";
constexpr std::string_view kHandshakeLabel = "hapton handshake";
constexpr std::string_view kPskLabel = "hapton psk";

static_assert(std::tuple_size_v<Secret> == crypto_aead_aes256gcm_KEYBYTES);
static_assert(kProtocolVersion < 128);  // the version takes one byte here and at the start of a datagram

class Hash {
 public:
  Hash(std::span<const std::uint8_t> key, std::size_t size) : size_(size) {
    crypto_generichash_init(&state_, key.data(), key.size(), size);
  }
  ~Hash() { sodium_memzero(&state_, sizeof state_); }
  Hash(const Hash&) = delete;
  Hash& operator=(const Hash&) = delete;

  void add(std::string_view label) {
    crypto_generichash_update(&state_, reinterpret_cast<const std::uint8_t*>(label.data()), label.size());
  }
  void add_version() {
    const auto version = static_cast<std::uint8_t>(kProtocolVersion);
    crypto_generichash_update(&state_, &version, 1);
  }
  void finish(std::uint8_t* into) { crypto_generichash_final(&state_, into, size_); }

 private:
  crypto_generichash_state state_;
  std::size_t size_;
};

Secret derive_of_version(const RoleKey& key, std::string_view label) noexcept {
  Secret derived;
  Hash hash(key.bytes(), derived.size());
  hash.add(label);
  hash.add_version();
  hash.finish(derived.data());
  return derived;
}

}  // namespace

ChannelKeys::~ChannelKeys() {
  wipe(client_to_hub);
  wipe(hub_to_client);
}

Secret derive_role_key(const LinkKey& master, KeyRole role) noexcept {
  Secret derived;
  Hash hash(master.bytes(), derived.size());
  hash.add(kRoleLabel);
  hash.add(to_string(role));
  hash.finish(derived.data());
  return derived;
}

Secret derive_handshake_key(const RoleKey& key) noexcept { return derive_of_version(key, kHandshakeLabel); }

Secret derive_psk(const RoleKey& key) noexcept { return derive_of_version(key, kPskLabel); }

Tag compute_tag(const Secret& key, std::span<const std::uint8_t> bytes) noexcept {
  Tag tag;
  crypto_generichash(tag.data(), tag.size(), bytes.data(), bytes.size(), key.data(), key.size());
  return tag;
}

bool is_tag(const Tag& expected, const std::uint8_t* found) noexcept { return sodium_memcmp(expected.data(), found, expected.size()) == 0; }

void wipe(Secret& secret) noexcept { sodium_memzero(secret.data(), secret.size()); }

Result<void> start_crypto() {
  if (sodium_init() < 0) return fail("libsodium does not start: this system provides no random numbers (getrandom, /dev/urandom)");
  if (crypto_aead_aes256gcm_is_available() == 0) {
    return fail(
        "this processor has no AES instructions (aes, pclmulqdq), which the encryption needs; in a virtual machine, enable them for it");
  }
  return {};
}

}  // namespace hapton::seal
