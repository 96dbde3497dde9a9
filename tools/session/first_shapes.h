#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "link/messages.h"
#include "link/shape_parts.h"

namespace hapton {

// For a replay: the shapes that a haptics node had begun before its first force in a recording, of objects that programs deform. They are
// in the recording, some after that force, because the node repeats the newest ShapeStart of each object and the hub requests the vertices
// (decision 208). A first pass over the recording adds the messages, each with the sender of its datagram. RT: no. Threads: one.
class FirstShapes {
 public:
  // Shapes and starts in the order of their serials, so that the oldest come first.
  struct SenderShapes {
    std::optional<std::uint32_t> first;                                        // shape_serial of its first force; none: not there yet
    std::map<std::uint32_t, ShapeParts> shapes = {};                           // by serial
    std::map<std::pair<std::uint32_t, std::int32_t>, ShapeStart> starts = {};  // by serial and object
  };

  void add(std::uint64_t sender, const ForceCommand& force);
  void add(std::uint64_t sender, const ObjectShape& shape);
  void add(std::uint64_t sender, const ShapeStart& start);

  // Returns null if this sender sent none of these messages.
  const SenderShapes* find(std::uint64_t sender) const;

 private:
  // The most shapes, and the most starts, that are kept for a sender; the oldest is dropped. Before the first force tells which serials
  // count, a damaged or hostile file may have any number of them. A free choice.
  static constexpr std::size_t kMaxEarly = 64;

  std::map<std::uint64_t, SenderShapes> senders_;
};

}  // namespace hapton
