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

  // The events of keys and mouse since the last call, in order.
  std::vector<WindowEvent> poll();
  // True: the window was resized or uncovered since the last call, or this is the first call.
  bool take_redraw_request();

 private:
  void receive(unsigned long event);

  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
  std::vector<WindowEvent> events_;
  bool needs_redraw_ = true;
};

}  // namespace hapton
