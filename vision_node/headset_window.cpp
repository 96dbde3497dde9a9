#include "vision_node/headset_window.h"

#include <vtkOpenGLFramebufferObject.h>
#include <vtkXOpenGLRenderWindow.h>

// Included last: its macros (None, Success, Bool ...) break other headers.
#include <GL/glx.h>

namespace hapton {

PictureSize HeadsetWindow::mapped_size() const {
  if (!is_mapped_) return size_;
  XWindowAttributes now;
  auto* const display = static_cast<Display*>(window_->GetGenericDisplayId());
  XGetWindowAttributes(display, reinterpret_cast<Window>(window_->GetGenericWindowId()), &now);
  return {now.width, now.height};
}

void HeadsetWindow::enter(PictureSize eye_size) {
  if (eye_size_.width_px == 0) {
    window_->MakeCurrent();
    window_->SetSwapControl(0);  // the headset sets the pace, not the screen
  }
  eye_size_ = eye_size;
  window_->UseOffScreenBuffersOn();
  vtkXOpenGLRenderWindow::SafeDownCast(window_)->SetSizeNoXResize(2 * eye_size.width_px, eye_size.height_px);
}

void HeadsetWindow::leave() {
  if (eye_size_.width_px == 0) return;
  eye_size_ = {};
  window_->MakeCurrent();
  window_->SetSwapControl(1);
  window_->SetUseOffScreenBuffers(!is_mapped_);
  const PictureSize size = mapped_size();
  vtkXOpenGLRenderWindow::SafeDownCast(window_)->SetSizeNoXResize(size.width_px, size.height_px);
}

void HeadsetWindow::take_frame() {
  window_->MakeCurrent();
  copies_.take(window_->GetRenderFramebuffer()->GetFBOIndex(), eye_size_);
}

void HeadsetWindow::show_mirror() {
  if (!is_mapped_) return;
  const PictureSize window = mapped_size();
  if (window.width_px <= 0 || window.height_px <= 0) return;
  copies_.copy_to_window(place_mirror(window, eye_size_));
  glXSwapBuffers(static_cast<Display*>(window_->GetGenericDisplayId()), reinterpret_cast<GLXDrawable>(window_->GetGenericWindowId()));
}

Eigen::Vector2i HeadsetWindow::find_pixel(int window_x_px, int window_y_px) const {
  if (eye_size_.width_px == 0) return {window_x_px, window_y_px};
  return place_mirror(mapped_size(), eye_size_).to_eye(window_x_px, window_y_px, eye_size_);
}

GlxWindow HeadsetWindow::handles() {
  window_->MakeCurrent();
  auto* const display = static_cast<Display*>(window_->GetGenericDisplayId());
  GlxWindow handles;
  handles.display = display;
  handles.context = glXGetCurrentContext();
  handles.drawable = glXGetCurrentDrawable();
  int id = 0;
  int screen = 0;
  glXQueryContext(display, glXGetCurrentContext(), GLX_FBCONFIG_ID, &id);
  glXQueryContext(display, glXGetCurrentContext(), GLX_SCREEN, &screen);
  const int wanted[] = {GLX_FBCONFIG_ID, id, None};
  int count = 0;
  GLXFBConfig* const found = glXChooseFBConfig(display, screen, wanted, &count);
  if (found == nullptr) return handles;
  if (count > 0) {
    handles.framebuffer_config = found[0];
    if (XVisualInfo* const visual = glXGetVisualFromFBConfig(display, found[0]); visual != nullptr) {
      handles.visual_id = static_cast<std::uint32_t>(visual->visualid);
      XFree(visual);
    }
  }
  XFree(found);
  return handles;
}

}  // namespace hapton
