#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "link/patch_messages.h"

namespace hapton {

// How many parts (PatchEffects) so many bytes of effects take. RT: yes.
constexpr std::uint32_t count_effect_parts(std::size_t bytes) noexcept {
  return static_cast<std::uint32_t>((bytes + PatchEffects::kMaxBytes - 1) / PatchEffects::kMaxBytes);
}

// Makes the part of this number, without epoch and serial. Pre: part < count_effect_parts(bytes.size()).
inline PatchEffects make_effect_part(std::string_view bytes, std::uint32_t part) noexcept {
  const std::string_view here = bytes.substr(part * PatchEffects::kMaxBytes, PatchEffects::kMaxBytes);
  PatchEffects message{.part = part, .byte_count = static_cast<std::uint32_t>(here.size())};
  std::copy(here.begin(), here.end(), message.bytes.begin());
  return message;
}

// Collects the parts of a scene's effects, in any order. RT: no. Threads: one.
class EffectParts {
 public:
  // False: a part of that number came before with other bytes. The length of a part is not checked: compare that of join().
  bool take(const PatchEffects& part) {
    if (part.part >= parts_.size()) parts_.resize(part.part + 1);
    std::string& own = parts_[part.part];
    const std::string_view here(reinterpret_cast<const char*>(part.bytes.data()),
                                std::min<std::size_t>(part.byte_count, part.bytes.size()));
    if (!own.empty()) return own == here;
    own = here;
    return true;
  }

  // True if all parts of so many bytes have come.
  bool is_whole(std::size_t bytes) const {
    const std::size_t count = count_effect_parts(bytes);
    return parts_.size() >= count && std::none_of(parts_.begin(), parts_.begin() + static_cast<std::ptrdiff_t>(count),
                                                  [](const std::string& part) { return part.empty(); });
  }
  std::string join() const {
    std::string all;
    for (const std::string& part : parts_) all += part;
    return all;
  }

 private:
  std::vector<std::string> parts_;  // by number; empty: the part has not come
};

}  // namespace hapton
