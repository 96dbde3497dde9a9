#pragma once

#include <cstdint>

#include "vision_node/flat_level.h"

namespace hapton {

// A level of detail in the graphics driver's memory. Threads: the window's; its context is current.
struct FlatBuffers {
  std::uint32_t array = 0;
  std::uint32_t buffer = 0;
  std::uint32_t paints = 0;  // 0: of one colour
};

FlatBuffers upload(const FlatLevel& level, std::uint32_t index_buffer);
void release(FlatBuffers& buffers);

}  // namespace hapton
