#pragma once

class vtkOpenGLRenderWindow;

namespace hapton {

// Brings what VTK has drawn into its framebuffer to the window on the screen. RT: no. Threads: the window's.
void present(vtkOpenGLRenderWindow* window);

}  // namespace hapton
