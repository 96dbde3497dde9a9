#include "vision_node/gl_program.h"

#include <array>
#include <string>
#include <utility>

namespace hapton {
namespace {

Result<GLuint> compile(GLenum kind, std::string_view source) {
  const GLuint shader = glCreateShader(kind);
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader, 1, &text, &length);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok != 0) return shader;
  std::array<char, 512> log = {};
  glGetShaderInfoLog(shader, log.size() - 1, nullptr, log.data());
  glDeleteShader(shader);
  return fail("the graphics driver rejects a shader: {}", log.data());
}

}  // namespace

Result<GlProgram> GlProgram::make(std::string_view vertex, std::string_view fragment) {
  const auto vertex_shader = compile(GL_VERTEX_SHADER, vertex);
  if (!vertex_shader) return tl::unexpected(vertex_shader.error());
  const auto fragment_shader = compile(GL_FRAGMENT_SHADER, fragment);
  if (!fragment_shader) {
    glDeleteShader(*vertex_shader);
    return tl::unexpected(fragment_shader.error());
  }
  GlProgram made(glCreateProgram());
  glBindAttribLocation(made.program_, 0, "position");
  glBindAttribLocation(made.program_, 1, "direction");
  glBindAttribLocation(made.program_, 2, "tint");
  glBindAttribLocation(made.program_, 3, "place");
  glBindAttribLocation(made.program_, 4, "finish");
  for (const GLuint shader : {*vertex_shader, *fragment_shader}) {
    glAttachShader(made.program_, shader);
    glDeleteShader(shader);  // the shader is deleted together with the program
  }
  glLinkProgram(made.program_);
  GLint ok = 0;
  glGetProgramiv(made.program_, GL_LINK_STATUS, &ok);
  if (ok != 0) return made;
  std::array<char, 512> log = {};
  glGetProgramInfoLog(made.program_, log.size() - 1, nullptr, log.data());
  return fail("the graphics driver rejects a shader program: {}", log.data());
}

GlProgram::GlProgram(GlProgram&& other) noexcept : program_(std::exchange(other.program_, 0)) {}

GlProgram& GlProgram::operator=(GlProgram&& other) noexcept {
  std::swap(program_, other.program_);
  return *this;
}

GlProgram::~GlProgram() {
  if (program_ != 0) glDeleteProgram(program_);
}

void GlProgram::set(const char* name, const Eigen::Matrix4d& m) const {
  const Eigen::Matrix4f single = m.cast<float>();
  glUniformMatrix4fv(find(name), 1, GL_FALSE, single.data());
}

void GlProgram::set(const char* name, const Vec3& v) const {
  const Eigen::Vector3f single = v.cast<float>();
  glUniform3fv(find(name), 1, single.data());
}

void GlProgram::set(const char* name, double x) const { glUniform1f(find(name), static_cast<float>(x)); }
void GlProgram::set(const char* name, int i) const { glUniform1i(find(name), i); }

}  // namespace hapton
