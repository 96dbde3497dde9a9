#pragma once

#include "core/base/result.h"

namespace hapton {

// A connection to the X display, shared by all windows and kept until the process ends: VTK aborts the process if it cannot connect; a
// virtual display resets itself when its last client leaves, rejecting clients meanwhile; and OpenGL's driver would be unloaded with the
// last connection and loaded again with the next.
class DisplayConnection {
 public:
  // Error, one line: no DISPLAY, one that cannot be reached, or one without OpenGL (GLX); it says how to get a virtual display.
  static Result<DisplayConnection> open();

  // Xlib's Display*, in the type in which VTK takes it.
  void* id() const { return display_; }

 private:
  explicit DisplayConnection(void* display) : display_(display) {}
  void* display_;
};

}  // namespace hapton
