#pragma once

#include <cstdint>

#include "vision_node/flat_level.h"

namespace hapton {

// The OpenGL objects, by name, that hold a level of detail. Threads: the window's, with its context current. RT: no.
struct FlatBuffers {
  std::uint32_t array = 0;   // vertex array object
  std::uint32_t buffer = 0;  // buffer object with FlatLevel::vertices
  std::uint32_t paints = 0;  // buffer object with FlatLevel::paints; 0: the level has one colour
};

// Makes the objects for a level. index_buffer: name of an element buffer; the vertex array refers to it, release() does not delete it.
FlatBuffers upload(const FlatLevel& level, std::uint32_t index_buffer);
void release(FlatBuffers& buffers);

}  // namespace hapton
