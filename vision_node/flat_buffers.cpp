#include "vision_node/flat_buffers.h"

#include <cstddef>

#include <GL/glew.h>

namespace hapton {
namespace {

// Adds the paint attributes to the bound vertex array. Attribute numbers are those of gl_program.cpp.
GLuint upload_paints(const std::vector<VertexPaint>& paints) {
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(paints.size() * sizeof(VertexPaint)), paints.data(), GL_STATIC_DRAW);
  glEnableVertexAttribArray(2);
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(VertexPaint), nullptr);
  glEnableVertexAttribArray(3);
  glVertexAttribPointer(3, 2, GL_FLOAT, GL_FALSE, sizeof(VertexPaint), reinterpret_cast<const void*>(offsetof(VertexPaint, texcoord)));
  glEnableVertexAttribArray(4);
  glVertexAttribPointer(4, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(VertexPaint), reinterpret_cast<const void*>(offsetof(VertexPaint, alpha)));
  return buffer;
}

}  // namespace

void release(FlatBuffers& buffers) {
  if (buffers.array != 0) glDeleteVertexArrays(1, &buffers.array);
  if (buffers.buffer != 0) glDeleteBuffers(1, &buffers.buffer);
  if (buffers.paints != 0) glDeleteBuffers(1, &buffers.paints);
  buffers = {};
}

FlatBuffers upload(const FlatLevel& level, std::uint32_t index_buffer) {
  const std::vector<FlatVertex>& vertices = level.vertices;
  FlatBuffers made;
  glGenVertexArrays(1, &made.array);
  glGenBuffers(1, &made.buffer);
  glBindVertexArray(made.array);
  glBindBuffer(GL_ARRAY_BUFFER, made.buffer);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(FlatVertex)), vertices.data(), GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(FlatVertex), nullptr);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 4, GL_INT_2_10_10_10_REV, GL_TRUE, sizeof(FlatVertex),
                        reinterpret_cast<const void*>(offsetof(FlatVertex, normal)));
  if (!level.paints.empty()) made.paints = upload_paints(level.paints);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  return made;
}

}  // namespace hapton
