#include "link/address.h"

#include <algorithm>

namespace hapton {
namespace {

constexpr std::array<std::uint8_t, 12> kV4Mapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
constexpr std::size_t kV4At = kV4Mapped.size();

}  // namespace

bool is_v4(const Address& address) noexcept { return std::equal(kV4Mapped.begin(), kV4Mapped.end(), address.ip.begin()); }

bool is_loopback(const Address& address) noexcept {
  constexpr std::array<std::uint8_t, 16> kV6 = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  return is_v4(address) ? address.ip[kV4At] == 127 : address.ip == kV6;
}

std::string_view any_address_like(const Address& peer) noexcept { return is_v4(peer) ? "0.0.0.0:0" : "[::]:0"; }

}  // namespace hapton
