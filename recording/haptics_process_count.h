#pragma once

#include <cstdint>
#include <optional>
#include <type_traits>
#include <variant>

#include "link/messages.h"

namespace hapton {

// Counts the haptics processes of a recording whose moves, carves or shapes were recorded: a process has one number in all tables. RT: yes.
class HapticsProcessCount {
 public:
  // Takes each message that the hub received, in their order.
  void add(const Message& message) noexcept {
    const std::optional<std::uint32_t> source = find_source(message);
    if (!source || source == source_) return;
    number_ += source_ ? 1 : 0;
    source_ = source;
  }
  // The number of the newest process, from 0. In each process all objects begin at rest and whole.
  std::uint32_t number() const noexcept { return number_; }

 private:
  static std::optional<std::uint32_t> find_source(const Message& message) noexcept {
    return std::visit(
        []<class Kind>(const Kind& one) -> std::optional<std::uint32_t> {
          constexpr bool kIsOfObjects = std::is_same_v<Kind, ObjectMove> || std::is_same_v<Kind, Carves> ||
                                        std::is_same_v<Kind, ObjectShape> || std::is_same_v<Kind, ShapeStart>;
          if constexpr (kIsOfObjects) return one.source;
          return std::nullopt;
        },
        message);
  }

  std::optional<std::uint32_t> source_;
  std::uint32_t number_ = 0;
};

}  // namespace hapton
