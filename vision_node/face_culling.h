#pragma once

#include <GL/glew.h>

namespace hapton {

// Which sides of the triangles are drawn from here on: both, or where culls, only the fronts or only the backs. Backs lie a little behind
// their place, so that of two sheets back to back in one place the one that faces the eye is seen. Threads: as OpenGL.
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
