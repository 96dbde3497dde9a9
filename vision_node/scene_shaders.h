#pragma once

#include <string_view>

// The shaders of ScenePainter, GLSL of OpenGL 3.2.
namespace hapton {

// One colour for each triangle, from its last corner. The side that is seen is lit. The highlight's power of 18 by products.
inline constexpr std::string_view kVertexShader = R"(#version 150
in vec3 position;
in vec4 direction;
uniform mat4 to_clip, to_eye;
uniform vec3 colour, light;
uniform float haze_from, haze_to;
uniform int plain;
flat out vec3 shade;
out float far;
void main() {
  gl_Position = to_clip * vec4(position, 1.0);
  vec3 to_viewer = -(to_eye * vec4(position, 1.0)).xyz;
  vec3 normal = normalize(mat3(to_eye) * direction.xyz);
  normal *= dot(normal, to_viewer) < 0.0 ? -1.0 : 1.0;
  float towards = dot(normal, light);
  float mirrored = max(0.0, dot(2.0 * towards * normal - light, normalize(to_viewer)));
  float p2 = mirrored * mirrored;
  float p4 = p2 * p2;
  float p16 = p4 * p4;
  p16 *= p16;
  vec3 lit = colour * (0.20 + 0.88 * max(0.0, towards)) + 0.22 * p16 * p2 * step(0.0, towards);
  shade = plain != 0 ? colour : lit;
  far = clamp((to_viewer.z - haze_from) / (haze_to - haze_from), 0.0, 0.45);
}
)";

inline constexpr std::string_view kFragmentShader = R"(#version 150
flat in vec3 shade;
in float far;
uniform vec3 haze;
out vec4 shown;
void main() { shown = vec4(mix(shade, haze, far), 1.0); }
)";

// The same light for each triangle; its colour goes from corner to corner, and is that of a texture where there is one.
inline constexpr std::string_view kPaintedVertexShader = R"(#version 150
in vec3 position;
in vec4 direction;
in vec4 tint;
in vec2 place;
uniform mat4 to_clip, to_eye;
uniform vec3 light;
uniform float haze_from, haze_to;
uniform int plain;
flat out vec2 lit;
flat out float layer;
out vec3 colour;
out vec2 at;
out float far;
void main() {
  gl_Position = to_clip * vec4(position, 1.0);
  vec3 to_viewer = -(to_eye * vec4(position, 1.0)).xyz;
  vec3 normal = normalize(mat3(to_eye) * direction.xyz);
  normal *= dot(normal, to_viewer) < 0.0 ? -1.0 : 1.0;
  float towards = dot(normal, light);
  float mirrored = max(0.0, dot(2.0 * towards * normal - light, normalize(to_viewer)));
  float p2 = mirrored * mirrored;
  float p4 = p2 * p2;
  float p16 = p4 * p4;
  p16 *= p16;
  lit = plain != 0 ? vec2(1.0, 0.0) : vec2(0.20 + 0.88 * max(0.0, towards), 0.22 * p16 * p2 * step(0.0, towards));
  layer = floor(255.0 * tint.w + 0.5);
  colour = tint.rgb;
  at = place;
  far = clamp((to_viewer.z - haze_from) / (haze_to - haze_from), 0.0, 0.45);
}
)";

inline constexpr std::string_view kPaintedFragmentShader = R"(#version 150
flat in vec2 lit;
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
  shown = vec4(mix(own * lit.x + lit.y, haze, far), 1.0);
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

// One colour, wherever the matrix puts it.
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
