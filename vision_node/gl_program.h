#pragma once

#include <string_view>

#include <GL/glew.h>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// A shader program of our own, used beside those of VTK; OpenGL 3.2. Threads: the window's. RT: no. Pre: the window's context is current in
// every call, also in the destructor.
class GlProgram {
 public:
  // Compiles and links. The vertex shader's inputs `position`, `direction`, `tint`, `place` and `finish`, if used, have locations 0 to 4.
  // Error: the driver's message.
  static Result<GlProgram> make(std::string_view vertex, std::string_view fragment);
  GlProgram(GlProgram&& other) noexcept;
  GlProgram& operator=(GlProgram&& other) noexcept;
  ~GlProgram();

  void use() const { glUseProgram(program_); }
  // Each sets one uniform. Pre: this program is the one in use (use()).
  void set(const char* name, const Eigen::Matrix4d& m) const;
  void set(const char* name, const Vec3& v) const;
  void set(const char* name, double x) const;
  void set(const char* name, int i) const;

 private:
  explicit GlProgram(GLuint program) : program_(program) {}
  GLint find(const char* name) const { return glGetUniformLocation(program_, name); }
  GLuint program_ = 0;
};

}  // namespace hapton
