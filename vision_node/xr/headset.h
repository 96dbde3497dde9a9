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

// The window that draws, as OpenXR has to know it: handles of Xlib and GLX.
struct GlxWindow {
  void* display = nullptr;             // Display*
  unsigned long drawable = 0;          // GLXDrawable
  void* context = nullptr;             // GLXContext
  void* framebuffer_config = nullptr;  // GLXFBConfig
  std::uint32_t visual_id = 0;
};

// A headset, through the OpenXR runtime that is active on this machine. It is connected, then opened for a window; from then on attend() is
// called in each turn of the loop, and while it is_running() each begin_frame() is followed by end_frame(). The runtime sets the pace:
// begin_frame() waits until the next frame is due. A call that fails ends the use of the runtime (is_lost()), never the program. Frames: L,
// see RoomSpace. Threads: the window's, whose context is current in every call from open() on, also in the destructor, which ends the
// session in order (at most a second). RT: no. Source: OpenXR 1.0, https://registry.khronos.org/OpenXR.
class Headset {
 public:
  // Copies the image of an eye (0: the left one) into that texture of OpenGL, which has eye_size().
  using CopyEye = std::function<void(std::size_t eye, unsigned texture)>;

  // Error: one line, also where vision_node was built without OpenXR, no runtime is active, or no headset is connected.
  static Result<std::unique_ptr<Headset>> connect();
  ~Headset();

  // The runtime's name.
  const std::string& name() const;
  // The image that the runtime recommends for each eye.
  PictureSize eye_size() const;

  // Error: a runtime that has no such space, or rejects the window.
  Result<void> open(const GlxWindow& window, RoomSpace space);

  // Handles what the runtime has sent.
  void attend();
  // Frames are wanted.
  bool is_running() const;
  // The runtime has ended the session, as by its own menu.
  bool has_ended() const;
  bool is_lost() const;
  // How it was lost: the call and its result.
  const std::string& loss() const;

  // Waits until the next frame is due. True: eyes() are to be drawn. False: the headset shows nothing of us, or is lost. Pre: is_running().
  bool begin_frame();
  // Frame L, at the time when the frame will be seen; the last known ones while the headset is not tracked.
  const std::array<EyeInFrame, 2>& eyes() const;
  // copy is called once for each eye; null: the frame shows nothing. Pre: begin_frame() was true.
  void end_frame(const CopyEye& copy);

 private:
  struct Runtime;
  explicit Headset(std::unique_ptr<Runtime> runtime);
  std::unique_ptr<Runtime> runtime_;
};

}  // namespace hapton
