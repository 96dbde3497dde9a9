#include "vision_node/present.h"

#include <GL/glew.h>

#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>

#include "vision_node/gl_target.h"

// Included last: its macros (None, Success, Bool ...) break other headers.
#include <GL/glx.h>

namespace hapton {

void present(vtkOpenGLRenderWindow* window) {
  window->MakeCurrent();
  {
    const GlStateGuard guard;
    const int* size = window->GetSize();
    glDisable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, window->GetRenderFramebuffer()->GetFBOIndex());
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glDrawBuffer(GL_BACK);
    glBlitFramebuffer(0, 0, size[0], size[1], 0, 0, size[0], size[1], GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  glXSwapBuffers(static_cast<Display*>(window->GetGenericDisplayId()), reinterpret_cast<GLXDrawable>(window->GetGenericWindowId()));
}

}  // namespace hapton
