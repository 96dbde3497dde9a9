#pragma once

#include <GL/glew.h>

namespace hapton {

// Sets which sides of triangles are drawn from now on: both; with `culls` only the backs if `backs`, else only the fronts. With `backs`,
// they lie a little farther away: of two sheets back to back, the one that faces the eye is seen. Threads: that of the OpenGL context.
inline void set_drawn_side(bool culls, bool backs) {
  culls ? glEnable(GL_CULL_FACE) : glDisable(GL_CULL_FACE);
  glCullFace(backs ? GL_FRONT : GL_BACK);
  backs ? glEnable(GL_POLYGON_OFFSET_FILL) : glDisable(GL_POLYGON_OFFSET_FILL);
  // Depths of one triangle wound both ways differ by rounding, which grows with its slope: 8 steps alone leave hundreds of wrong pixels, a
  // slope of 0.1 none. At a slope of 1, a rim of what is behind shows at the outline of round bodies.
  constexpr GLfloat kSlope = 0.3F;
  constexpr GLfloat kSteps = 2.0F;
  glPolygonOffset(kSlope, kSteps);
}

}  // namespace hapton
