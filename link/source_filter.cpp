#include "link/source_filter.h"

#include <algorithm>

namespace hapton {
namespace {

constexpr std::uint32_t kNetwork = static_cast<std::uint32_t>(SKF_NET_OFF);  // linux/filter.h
constexpr std::uint32_t kAll = 0xFFFFFFFF;

}  // namespace

void SourceFilter::add(std::uint16_t code, std::uint32_t k, std::uint8_t jump_true, std::uint8_t jump_false) noexcept {
  program_[size_++] = {code, jump_true, jump_false, k};
}

// Compares the IP version, the words of the source's address, and its port; a mismatch jumps to the last instruction, which rejects.
SourceFilter::SourceFilter(const Address& peer) noexcept {
  const bool v4 = is_v4(peer);
  const std::uint8_t words = v4 ? 1 : 4;
  const std::size_t last = 3 + 2 * words + 2 + 1;
  const auto to_last = [&] { return static_cast<std::uint8_t>(last - size_ - 1); };
  add(BPF_LD | BPF_B | BPF_ABS, kNetwork);
  add(BPF_ALU | BPF_AND | BPF_K, 0xF0);
  add(BPF_JMP | BPF_JEQ | BPF_K, v4 ? 0x40 : 0x60, 0, to_last());
  for (std::uint32_t word = 0; word < words; ++word) {
    const std::uint8_t* bytes = peer.ip.data() + (v4 ? 12 : 4 * word);
    add(BPF_LD | BPF_W | BPF_ABS, kNetwork + (v4 ? 12 : 8) + 4 * word);
    const std::uint32_t wanted = static_cast<std::uint32_t>(bytes[0]) << 24 | static_cast<std::uint32_t>(bytes[1]) << 16 |
                                 static_cast<std::uint32_t>(bytes[2]) << 8 | bytes[3];
    add(BPF_JMP | BPF_JEQ | BPF_K, wanted, 0, to_last());
  }
  add(BPF_LD | BPF_H | BPF_ABS, 0);
  add(BPF_JMP | BPF_JEQ | BPF_K, peer.port, 0, to_last());
  add(BPF_RET | BPF_K, kAll);
  add(BPF_RET | BPF_K, 0);
}

}  // namespace hapton
