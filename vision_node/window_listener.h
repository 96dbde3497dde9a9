#pragma once

#include <vector>

#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkSmartPointer.h>

#include "vision_node/interaction.h"

namespace hapton {

// Receives keys, mouse and changes of a window. Threads: the window's. RT: no.
class WindowListener {
 public:
  explicit WindowListener(vtkRenderWindow* window);
  ~WindowListener();
  WindowListener(const WindowListener&) = delete;
  WindowListener& operator=(const WindowListener&) = delete;

  // What happened since the last call.
  std::vector<WindowEvent> poll();
  // The window was resized or uncovered since the last call.
  bool take_redraw_request();

 private:
  void receive(unsigned long event);

  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
  std::vector<WindowEvent> events_;
  bool needs_redraw_ = true;
};

}  // namespace hapton
