#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/xr/eye_frustum.h"
#include "vision_node/xr/workspace_place.h"

namespace hapton {

// Handles of Xlib and GLX of the window that draws, for OpenXR.
struct GlxWindow {
  void* display = nullptr;             // Display*
  unsigned long drawable = 0;          // GLXDrawable
  void* context = nullptr;             // GLXContext
  void* framebuffer_config = nullptr;  // GLXFBConfig
  std::uint32_t visual_id = 0;
};

// A headset, through the OpenXR runtime that is active on this machine. Call connect(), then open() for a window. Then, in
// each iteration of the main loop, call poll_events(), and while is_running() also begin_frame(), followed by end_frame() if it returns
// true. The runtime determines the frame rate: begin_frame() waits until the next frame is due. If a call of the runtime fails, the headset
// is lost (is_lost()) and the program goes on. Frame L: see RoomSpace. Threads: the window's, whose context is current in every call from
// open() on, also in the destructor, which takes up to a second to end the session. RT: no. Source: OpenXR 1.0,
// https://registry.khronos.org/OpenXR.
class Headset {
 public:
  // Copies the image of an eye (0: left) into an OpenGL texture of eye_size().
  using CopyEye = std::function<void(std::size_t eye, unsigned texture)>;

  // Error, one line: no runtime is active, no headset is connected, or vision_node was built without OpenXR.
  static Result<std::unique_ptr<Headset>> connect();
  ~Headset();

  // Name of the runtime.
  const std::string& name() const;
  // The image size that the runtime recommends for each eye.
  PictureSize eye_size() const;

  // Begins a session. Error, one line: the runtime lacks that space or a usable texture format, needs a newer OpenGL, or rejects a call.
  Result<void> open(const GlxWindow& window, RoomSpace space);

  // Handles the events of the runtime.
  void poll_events();
  // Whether the runtime requests frames.
  bool is_running() const;
  // Whether the runtime has ended the session, for example because the user closed it in the runtime's menu.
  bool has_ended() const;
  bool is_lost() const;
  // Why the headset is lost: mostly the call that failed and its result. Empty while is_lost() is false.
  const std::string& loss() const;

  // Waits until the next frame is due. True: draw eyes(), then call end_frame(). False: this frame is not shown, or the headset is lost.
  // Pre: is_running().
  bool begin_frame();
  // The eyes, left and right, at the time when the frame will be shown; the last known ones while the headset is not tracked. Frame L.
  const std::array<EyeInFrame, 2>& eyes() const;
  // Submits the frame. Calls copy once for each eye; null: the frame stays empty. Pre: begin_frame() returned true.
  void end_frame(const CopyEye& copy);

 private:
  struct Runtime;
  explicit Headset(std::unique_ptr<Runtime> runtime);
  std::unique_ptr<Runtime> runtime_;
};

}  // namespace hapton
