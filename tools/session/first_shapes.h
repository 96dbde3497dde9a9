#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "link/messages.h"
#include "link/shape_parts.h"

namespace hapton {

// For a replay: the shapes of objects that programs deform which a haptics node had begun before its first force in a recording. They are
// in the recording, also after that force, because the node repeats the newest start of each object and the hub requests the vertices
// (decision 208). A first pass over the recording adds its messages, by the sender of the datagrams. RT: no. Threads: one.
class FirstShapes {
 public:
  struct Sender {
    std::optional<std::uint32_t> first;                                        // shape_serial of its first force
    std::map<std::uint32_t, ShapeParts> shapes = {};                           // by serial
    std::map<std::pair<std::int32_t, std::uint32_t>, ShapeStart> starts = {};  // by object and serial
  };

  void add(std::uint64_t sender, const ForceCommand& force);
  void add(std::uint64_t sender, const ObjectShape& shape);
  void add(std::uint64_t sender, const ShapeStart& start);

  // Null if this sender sent nothing.
  const Sender* find(std::uint64_t sender) const;

 private:
  // Shapes and starts that are kept for a sender, the newest ones: until its first force tells which serials count, a damaged or hostile
  // file may have any number of them. A free choice.
  static constexpr std::size_t kMaxEarly = 64;

  std::map<std::uint64_t, Sender> senders_;
};

}  // namespace hapton
