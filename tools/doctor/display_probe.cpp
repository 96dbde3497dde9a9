#include "tools/doctor/display_probe.h"

#include <dlfcn.h>
#include <fmt/core.h>

#include <array>
#include <cstdlib>

namespace hapton::doctor {
namespace {

// The parts of Xlib and GLX that are used here, with the names and numbers of glx.h and glxproto.
struct XDisplay;
struct FbConfig;
struct GlContext;
using XId = unsigned long;

constexpr int kGlxDoubleBuffer = 5;  // this and the next constants are those of GLX (glx.h)
constexpr int kGlxStereo = 6;
constexpr int kGlxDrawableType = 0x8010;
constexpr int kGlxWindowBit = 0x1;
constexpr int kGlxPbufferBit = 0x4;
constexpr int kGlxRenderType = 0x8011;
constexpr int kGlxRgbaBit = 0x1;
constexpr int kGlxRgbaType = 0x8014;
constexpr int kGlxPbufferHeight = 0x8040;
constexpr int kGlxPbufferWidth = 0x8041;
constexpr unsigned kGlRenderer = 0x1F01;
constexpr unsigned kGlVersion = 0x1F02;

// A shared library and its functions. It stays loaded until the process ends.
class Library {
 public:
  explicit Library(const char* file) : handle_(::dlopen(file, RTLD_NOW | RTLD_GLOBAL)) {
    if (handle_ == nullptr) error_ = ::dlerror();
  }
  template <class Function>
  void find(const char* name, Function*& into) {
    if (handle_ == nullptr) return;
    into = reinterpret_cast<Function*>(::dlsym(handle_, name));
    if (into == nullptr && error_.empty()) error_ = fmt::format("there is no {}", name);
  }
  const std::string& error() const { return error_; }

 private:
  void* handle_;
  std::string error_;
};

struct Functions {
  XDisplay* (*open_display)(const char*) = nullptr;
  int (*default_screen)(XDisplay*) = nullptr;
  int (*query_extension)(XDisplay*, int*, int*) = nullptr;
  FbConfig** (*choose_config)(XDisplay*, int, const int*, int*) = nullptr;
  XId (*create_pbuffer)(XDisplay*, FbConfig*, const int*) = nullptr;
  GlContext* (*create_context)(XDisplay*, FbConfig*, int, GlContext*, int) = nullptr;
  int (*make_current)(XDisplay*, XId, XId, GlContext*) = nullptr;
  int (*is_direct)(XDisplay*, GlContext*) = nullptr;
  const unsigned char* (*get_string)(unsigned) = nullptr;
  std::string error;
};

Functions load() {
  Functions functions;
  Library x("libX11.so.6");
  x.find("XOpenDisplay", functions.open_display);
  x.find("XDefaultScreen", functions.default_screen);
  Library gl("libGL.so.1");
  gl.find("glXQueryExtension", functions.query_extension);
  gl.find("glXChooseFBConfig", functions.choose_config);
  gl.find("glXCreatePbuffer", functions.create_pbuffer);
  gl.find("glXCreateNewContext", functions.create_context);
  gl.find("glXMakeContextCurrent", functions.make_current);
  gl.find("glXIsDirect", functions.is_direct);
  gl.find("glGetString", functions.get_string);
  functions.error = !x.error().empty() ? x.error() : gl.error();
  return functions;
}

// Creates an off-screen context, only to read the renderer's name.
void query_renderer(const Functions& gl, XDisplay* display, int screen, DisplayReply& reply) {
  constexpr std::array attributes = {kGlxDrawableType, kGlxPbufferBit, kGlxRenderType, kGlxRgbaBit, 0};
  int count = 0;
  FbConfig** configs = gl.choose_config(display, screen, attributes.data(), &count);
  if (configs == nullptr || count == 0) {
    reply.error = "its OpenGL gives no surface to draw on";
    return;
  }
  constexpr std::array size = {kGlxPbufferWidth, 16, kGlxPbufferHeight, 16, 0};
  const XId surface = gl.create_pbuffer(display, configs[0], size.data());
  GlContext* context = gl.create_context(display, configs[0], kGlxRgbaType, nullptr, 1);
  if (context == nullptr || gl.make_current(display, surface, surface, context) == 0) {
    reply.error = "its OpenGL gives no context";
    return;
  }
  const auto text = [&](unsigned name) {
    const unsigned char* value = gl.get_string(name);
    return value == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(value));
  };
  reply.renderer = text(kGlRenderer);
  reply.version = text(kGlVersion);
  reply.is_direct = gl.is_direct(display, context) != 0;
}

bool has_stereo_visual(const Functions& gl, XDisplay* display, int screen) {
  constexpr std::array attributes = {kGlxStereo, 1, kGlxDoubleBuffer, 1, kGlxDrawableType, kGlxWindowBit, kGlxRenderType, kGlxRgbaBit, 0};
  int count = 0;
  return gl.choose_config(display, screen, attributes.data(), &count) != nullptr && count > 0;
}

}  // namespace

DisplayReply probe_display() {
  DisplayReply reply;
  const Functions gl = load();
  if (!gl.error.empty()) {
    reply.error = gl.error;
    return reply;
  }
  const char* name = std::getenv("DISPLAY");
  XDisplay* display = gl.open_display(nullptr);
  if (display == nullptr) {
    reply.error = fmt::format("no connection to DISPLAY={}", name == nullptr ? "" : name);
    return reply;
  }
  int error_base = 0;
  int event_base = 0;
  if (gl.query_extension(display, &error_base, &event_base) == 0) {
    reply.error = "it has no OpenGL (GLX)";
    return reply;
  }
  const int screen = gl.default_screen(display);
  reply.has_stereo = has_stereo_visual(gl, display, screen);
  query_renderer(gl, display, screen, reply);
  return reply;
}

}  // namespace hapton::doctor
