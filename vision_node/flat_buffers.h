#pragma once

#include <cstdint>

#include "vision_node/flat_level.h"

namespace hapton {

// OpenGL names of a level of detail in the graphics driver's memory. Threads: the window's, with its context current. RT: no.
struct FlatBuffers {
  std::uint32_t array = 0;   // vertex array object
  std::uint32_t buffer = 0;  // FlatLevel::vertices
  std::uint32_t paints = 0;  // FlatLevel::paints; 0: the level has one colour
};

// index_buffer: an element buffer, which the vertex array then refers to.
FlatBuffers upload(const FlatLevel& level, std::uint32_t index_buffer);
void release(FlatBuffers& buffers);

}  // namespace hapton
