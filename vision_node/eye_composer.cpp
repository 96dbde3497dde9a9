#include "vision_node/eye_composer.h"

#include <array>
#include <cstdint>
#include <utility>

#include "vision_node/gl_target.h"

namespace hapton {
namespace {

constexpr const char* kComposerVertexShader = R"(#version 150
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }
)";

// Uses whole numbers, as VTK does. table: what a value adds to a pixel's grey as red, as green and as blue, and what it keeps as a colour.
constexpr const char* kComposerFragmentShader = R"(#version 150
uniform sampler2D first, second, table;
uniform int has_colours;
out vec4 shown;
ivec4 bytes(vec4 given) { return ivec4(given * 255.0 + 0.5); }
ivec4 look_up(int value) { return bytes(texelFetch(table, ivec2(value, 0), 0)); }
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  ivec3 a = bytes(texelFetch(first, at, 0)).rgb;
  ivec3 b = bytes(texelFetch(second, at, 0)).rgb;
  ivec3 both = ivec3((a.r + a.g + a.b) / 3, 0, (b.r + b.g + b.b) / 3);
  if (has_colours != 0) {
    ivec4 red = look_up(a.r), green = look_up(b.g), blue = look_up(b.b);
    int grey_a = red.r + look_up(a.g).g + look_up(a.b).b;
    int grey_b = look_up(b.r).r + green.g + blue.b;
    both = ivec3(grey_a + red.a, grey_b + green.a, grey_b + blue.a);
  }
  shown = vec4(vec3(both) / 255.0, 1.0);
}
)";

// As vtkRenderWindow::StereoRenderComplete does with its default saturation: red from the first picture, green and blue from the second.
std::array<std::uint8_t, 4 * 256> make_anaglyph_table() {
  constexpr float kSaturation = 0.65F;
  constexpr double kShares[3] = {0.3086, 0.6094, 0.0820};
  std::array<std::uint8_t, 4 * 256> table = {};
  for (std::size_t x = 0; x < 256; ++x) {
    for (std::size_t k = 0; k < 3; ++k) {
      table[4 * x + k] = static_cast<std::uint8_t>((1.0 - kSaturation) * static_cast<double>(x) * kShares[k]);
    }
    table[4 * x + 3] = static_cast<std::uint8_t>(kSaturation * static_cast<float>(x));
  }
  return table;
}

// Saves the textures of three units, which GlStateGuard does not save. VTK does not use these units for a whole picture.
class TextureState {
 public:
  TextureState() {
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active_);
    for (GLint unit = 0; unit < kUnits; ++unit) {
      glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
      glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound_[static_cast<std::size_t>(unit)]);
    }
  }
  ~TextureState() {
    for (GLint unit = 0; unit < kUnits; ++unit) bind(unit, static_cast<GLuint>(bound_[static_cast<std::size_t>(unit)]));
    glActiveTexture(static_cast<GLenum>(active_));
  }
  TextureState(const TextureState&) = delete;
  TextureState& operator=(const TextureState&) = delete;

  static void bind(GLint unit, GLuint texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, texture);
  }

 private:
  static constexpr GLint kUnits = 3;
  GLint active_ = 0;
  std::array<GLint, kUnits> bound_ = {};
};

void allocate_texture(GLuint texture, PictureSize size, const void* texels) {
  TextureState::bind(0, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size.width_px, size.height_px, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

}  // namespace

Result<std::unique_ptr<EyeComposer>> EyeComposer::make() {
  auto program = GlProgram::make(kComposerVertexShader, kComposerFragmentShader);
  if (!program) return tl::unexpected(program.error());
  return std::unique_ptr<EyeComposer>(new EyeComposer(std::move(*program)));
}

EyeComposer::EyeComposer(GlProgram program) : program_(std::move(program)) {
  const GlStateGuard guard;
  const TextureState textures;
  glGenVertexArrays(1, &vertices_);
  glGenTextures(1, &table_);
  const auto table = make_anaglyph_table();
  allocate_texture(table_, {256, 1}, table.data());
  for (Copy* copy : {&first_eye_, &second_eye_}) {
    glGenTextures(1, &copy->texture);
    glGenFramebuffers(1, &copy->framebuffer);
  }
}

EyeComposer::~EyeComposer() {
  for (const Copy& copy : {first_eye_, second_eye_}) {
    glDeleteFramebuffers(1, &copy.framebuffer);
    glDeleteTextures(1, &copy.texture);
  }
  glDeleteTextures(1, &table_);
  glDeleteVertexArrays(1, &vertices_);
}

void EyeComposer::copy_colours(Copy& copy, GLuint framebuffer, PictureSize size) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, copy.framebuffer);
  if (copy.size != size) {
    copy.size = size;
    allocate_texture(copy.texture, size, nullptr);
    glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, copy.texture, 0);
  }
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glDisable(GL_SCISSOR_TEST);
  glBlitFramebuffer(0, 0, size.width_px, size.height_px, 0, 0, size.width_px, size.height_px, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void EyeComposer::keep_first_eye(GLuint framebuffer, PictureSize size) {
  const GlStateGuard guard;
  const TextureState textures;
  copy_colours(first_eye_, framebuffer, size);
}

void EyeComposer::compose(GLuint framebuffer, PictureSize size, bool has_colours) {
  const GlStateGuard guard;
  const TextureState textures;
  copy_colours(second_eye_, framebuffer, size);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, size.width_px, size.height_px);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_FALSE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  program_.use();
  program_.set("first", 0);
  program_.set("second", 1);
  program_.set("table", 2);
  program_.set("has_colours", has_colours ? 1 : 0);
  TextureState::bind(0, first_eye_.texture);
  TextureState::bind(1, second_eye_.texture);
  TextureState::bind(2, table_);
  glBindVertexArray(vertices_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace hapton
