#include "vision_node/display.h"

#include <chrono>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

#include <X11/Xlib.h>

namespace hapton {
namespace {

// A virtual display rejects connections for some milliseconds while it resets itself.
constexpr int kTries = 4;
constexpr std::chrono::milliseconds kBetweenTries{50};

Display* connect() {
  Display* display = XOpenDisplay(nullptr);
  for (int tries = 0; display == nullptr && tries < kTries; ++tries) {
    std::this_thread::sleep_for(kBetweenTries);
    display = XOpenDisplay(nullptr);
  }
  return display;
}

}  // namespace

Result<DisplayConnection> DisplayConnection::open() {
  constexpr const char* kRemedy =
      "start it from a desktop, or on a virtual display: xvfb-run -a -s '-screen 0 1280x1024x24' vision_node ... (deploy/run --headless "
      "does so)";
  const char* name = std::getenv("DISPLAY");
  if (name == nullptr || *name == '\0') return fail("no display: DISPLAY is not set; {}", kRemedy);
  static std::map<std::string, Display*>* const connections = new std::map<std::string, Display*>;
  if (const auto known = connections->find(name); known != connections->end()) return DisplayConnection(known->second);
  Display* display = connect();
  if (display == nullptr) return fail("no display: cannot connect to DISPLAY={}; {}", name, kRemedy);
  int major = 0;
  int event = 0;
  int error = 0;
  if (XQueryExtension(display, "GLX", &major, &event, &error) == 0) {
    XCloseDisplay(display);
    return fail("display {} has no OpenGL (GLX): use one that has; {}", name, kRemedy);
  }
  connections->emplace(name, display);
  return DisplayConnection(display);
}

}  // namespace hapton
