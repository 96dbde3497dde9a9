#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "link/messages.h"
#include "link/shape_parts.h"

namespace hapton {

// The shapes that a haptics node had begun before its first force in a recording, of objects that programs deform. The recording has them,
// because the node repeats the newest start of each object, and the hub requests the vertices (decision 208). Collected in a first pass
// over the recording, by sender of the datagrams. RT: no.
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
  // Limit on the shapes that are kept before the first force, which tells the serials that are in use; a file may have any number.
  static constexpr std::size_t kMaxEarly = 64;

  std::map<std::uint64_t, Sender> senders_;
};

}  // namespace hapton
