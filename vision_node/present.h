#pragma once

class vtkOpenGLRenderWindow;

namespace hapton {

// Copies the picture that VTK has drawn into its own framebuffer to the window on the screen. RT: no. Threads: the window's.
void present(vtkOpenGLRenderWindow* window);

}  // namespace hapton
