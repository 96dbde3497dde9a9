#pragma once

#include <memory>

#include "core/base/result.h"

namespace hapton {

// A connection to the X display, kept open for as long as anything is drawn: VTK aborts the whole process when it cannot connect, and
// a virtual display resets itself whenever its last client leaves, refusing those who come meanwhile.
class DisplayConnection {
 public:
  // Error: no DISPLAY, one that cannot be reached, or one without OpenGL (GLX); the line says how to get a virtual one.
  static Result<DisplayConnection> open();

 private:
  explicit DisplayConnection(std::shared_ptr<void> display) : display_(std::move(display)) {}
  std::shared_ptr<void> display_;
};

}  // namespace hapton
