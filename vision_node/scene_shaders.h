#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

// The shaders of ScenePainter, GLSL of OpenGL 3.2.
namespace hapton {

// The beginning of each of these shaders of lit triangles, before kLighting. LIT: two values, of which [0] multiplies a colour and [1] is
// then added; with the one white light that moves with the viewer (lights: 0), they are the same for red, green and blue.
inline std::string shader_head(std::size_t lights) {
  return fmt::format("#version 150\n#define LIGHTS {}\n#define LIT {}\n", lights, lights == 0 ? "vec2" : "mat2x3");
}

// Comes next in every vertex shader of lit triangles: computes position and light of a vertex. The side of a triangle that is seen is lit:
// a share of its own colour, and the highlight, whose power of 18 is computed by products. A light of the scene has a position in the eye's
// frame, or a direction.
inline constexpr std::string_view kLighting = R"(
uniform mat4 to_clip, to_eye;
uniform float haze_from, haze_to;
uniform int plain;
out float far;
float shine(vec3 normal, vec3 light, float towards, vec3 to_viewer) {
  float mirrored = max(0.0, dot(2.0 * towards * normal - light, normalize(to_viewer)));
  float p2 = mirrored * mirrored;
  float p4 = p2 * p2;
  float p16 = p4 * p4;
  p16 *= p16;
  return 0.22 * p16 * p2 * step(0.0, towards);
}
#if LIGHTS == 0
uniform vec3 light;
LIT light_up(vec3 normal, vec3 to_viewer) {
  float towards = dot(normal, light);
  return plain != 0 ? vec2(1.0, 0.0) : vec2(0.20 + 0.88 * max(0.0, towards), shine(normal, light, towards, to_viewer));
}
#else
uniform vec3 light_at[LIGHTS], light_colours[LIGHTS];
uniform float light_has_position[LIGHTS];
LIT light_up(vec3 normal, vec3 to_viewer) {
  LIT lit = LIT(vec3(0.20), vec3(0.0));
  for (int i = 0; i < LIGHTS; ++i) {
    vec3 light = normalize(light_at[i] + light_has_position[i] * to_viewer);
    float towards = dot(normal, light);
    lit[0] += 0.88 * max(0.0, towards) * light_colours[i];
    lit[1] += shine(normal, light, towards, to_viewer) * light_colours[i];
  }
  return plain != 0 ? LIT(vec3(1.0), vec3(0.0)) : lit;
}
#endif
LIT place_and_light(vec3 position, vec3 direction) {
  gl_Position = to_clip * vec4(position, 1.0);
  vec3 to_viewer = -(to_eye * vec4(position, 1.0)).xyz;
  vec3 normal = normalize(mat3(to_eye) * direction);
  normal *= dot(normal, to_viewer) < 0.0 ? -1.0 : 1.0;
  far = clamp((to_viewer.z - haze_from) / (haze_to - haze_from), 0.0, 0.45);
  return light_up(normal, to_viewer);
}
)";

// Follows kLighting. One colour for each triangle, from its last corner.
inline constexpr std::string_view kVertexShader = R"(
in vec3 position;
in vec4 direction;
uniform vec3 colour;
flat out vec3 shade;
void main() {
  LIT lit = place_and_light(position, direction.xyz);
  shade = colour * lit[0] + lit[1];
}
)";

inline constexpr std::string_view kFragmentShader = R"(
flat in vec3 shade;
in float far;
uniform vec3 haze;
out vec4 shown;
void main() { shown = vec4(mix(shade, haze, far), 1.0); }
)";

// Follows kLighting. One light for each triangle; its colour varies between its corners, multiplied by the texture if there is one.
inline constexpr std::string_view kPaintedVertexShader = R"(
in vec3 position;
in vec4 direction;
in vec4 tint;
in vec2 place;
flat out LIT lit;
flat out float layer;
out vec3 colour;
out vec2 at;
void main() {
  lit = place_and_light(position, direction.xyz);
  layer = floor(255.0 * tint.w + 0.5);
  colour = tint.rgb;
  at = place;
}
)";

inline constexpr std::string_view kPaintedFragmentShader = R"(
flat in LIT lit;
flat in float layer;
in vec3 colour;
in vec2 at;
in float far;
uniform vec3 haze;
uniform int textured;
uniform sampler2DArray images;
out vec4 shown;
void main() {
  vec3 own = colour;
  if (textured != 0) own *= mix(vec3(1.0), texture(images, vec3(at, max(0.0, layer - 1.0))).rgb, step(0.5, layer));
  shown = vec4(mix(own * lit[0] + lit[1], haze, far), 1.0);
}
)";

// Follows kLighting. Painted, with alpha and a texture that need not repeat. finish: alpha, cutoff, blended or not, wraps, as in
// VertexPaint.
inline constexpr std::string_view kFinishedVertexShader = R"(
in vec3 position;
in vec4 direction;
in vec4 tint;
in vec2 place;
in vec4 finish;
flat out LIT lit;
flat out float layer;
flat out vec4 kind;
out vec4 colour;
out vec2 at;
void main() {
  lit = place_and_light(position, direction.xyz);
  layer = floor(255.0 * tint.w + 0.5);
  float wraps = floor(255.0 * finish.w + 0.5);
  kind = vec4(finish.y, finish.z > 0.0 ? 1.0 : 0.0, mod(wraps, 4.0), floor(wraps / 4.0));
  colour = vec4(tint.rgb, finish.x);
  at = place;
}
)";

// The driver repeats the texture. In a direction in which it must not repeat, the texture position is kept half a texel from the edge, in
// the level of the texture that is sampled: nearer to the edge, the driver mixes in the opposite edge.
inline constexpr std::string_view kFinishedFragmentShader = R"(
flat in LIT lit;
flat in float layer;
flat in vec4 kind;
in vec4 colour;
in vec2 at;
in float far;
uniform vec3 haze;
uniform int textured;
uniform sampler2DArray images;
out vec4 shown;
vec4 sample_image() {
  vec2 size = vec2(textureSize(images, 0).xy);
  vec2 right = dFdx(at), up = dFdy(at);
  float texels = max(1.0, max(length(right * size), length(up * size)));
  vec2 edge = min(vec2(0.5), 0.5 * exp2(floor(log2(texels) + 0.5)) / size);
  vec2 mirrored = 1.0 - abs(mod(at, 2.0) - 1.0);
  vec2 bounded = clamp(mix(mirrored, at, step(1.5, kind.zw)), edge, 1.0 - edge);
  vec2 where = mix(at, bounded, step(0.5, kind.zw));
  return textureGrad(images, vec3(where, max(0.0, layer - 1.0)), right, up);
}
void main() {
  vec4 own = colour;
  if (textured != 0) own *= mix(vec4(1.0), sample_image(), step(0.5, layer));
  if (own.a < kind.x - 0.25 / 255.0) discard;
  shown = vec4(mix(own.rgb * lit[0] + lit[1], haze, far), mix(1.0, own.a, kind.y));
}
)";

inline constexpr std::string_view kBackgroundVertexShader = R"(#version 150
out float height;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = 0.5 * corner.y + 0.5;
  gl_Position = vec4(corner, 1.0, 1.0);
}
)";

inline constexpr std::string_view kBackgroundFragmentShader = R"(#version 150
in float height;
uniform vec3 low, high;
out vec4 shown;
void main() { shown = vec4(mix(low, high, height), 1.0); }
)";

// Draws in one colour, at the place that the matrix gives.
inline constexpr std::string_view kSingleVertexShader = R"(#version 150
in vec3 position;
uniform mat4 to_clip;
void main() { gl_Position = to_clip * vec4(position, 1.0); }
)";

inline constexpr std::string_view kSingleFragmentShader = R"(#version 150
uniform vec3 colour;
out vec4 shown;
void main() { shown = vec4(colour, 1.0); }
)";

}  // namespace hapton
