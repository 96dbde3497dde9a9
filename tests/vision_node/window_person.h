#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

// X's macros (None, Success, Bool ...) break other headers: include this last.
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>

namespace hapton {

// Another X client, in place of a person who presses keys and buttons, and closes and resizes the window.
class Person {
 public:
  Person() : display_(XOpenDisplay(nullptr), XCloseDisplay) { window_ = find_window(DefaultRootWindow(display_.get())); }

  bool has_window() const { return window_ != 0; }

  void press_key(KeySym symbol, unsigned modifiers = 0) {
    XKeyEvent key = {};
    key.type = KeyPress;
    key.window = window_;
    key.root = DefaultRootWindow(display_.get());
    key.keycode = XKeysymToKeycode(display_.get(), symbol);
    key.state = modifiers;
    key.same_screen = True;
    send(key, KeyPressMask);
  }

  void send_button(int type, unsigned number, int x, int y, unsigned modifiers = 0) {
    XButtonEvent event = {};
    event.type = type;
    event.window = window_;
    event.root = DefaultRootWindow(display_.get());
    event.button = number;
    event.x = x;
    event.y = y;
    event.state = modifiers;
    event.same_screen = True;
    send(event, type == ButtonPress ? ButtonPressMask : ButtonReleaseMask);
  }

  // Moves the real pointer, since VTK reads its position instead of the event's.
  void move_pointer(int x, int y) {
    XWarpPointer(display_.get(), None, window_, 0, 0, 0, 0, x, y);
    XSync(display_.get(), False);
  }

  void close() {
    XClientMessageEvent event = {};
    event.type = ClientMessage;
    event.window = window_;
    event.message_type = XInternAtom(display_.get(), "WM_PROTOCOLS", False);
    event.format = 32;
    event.data.l[0] = static_cast<long>(XInternAtom(display_.get(), "WM_DELETE_WINDOW", False));
    send(event, NoEventMask);
  }

  void resize(unsigned width, unsigned height) {
    XResizeWindow(display_.get(), window_, width, height);
    XSync(display_.get(), False);
  }

  // What the screen shows of the window: 3 bytes a pixel, rows from the bottom.
  std::vector<std::uint8_t> read_pixels(unsigned width, unsigned height) {
    std::vector<std::uint8_t> rgb;
    XImage* const image = XGetImage(display_.get(), window_, 0, 0, width, height, AllPlanes, ZPixmap);
    if (image == nullptr) return rgb;
    for (int y = static_cast<int>(height) - 1; y >= 0; --y) {
      for (int x = 0; x < static_cast<int>(width); ++x) {
        const unsigned long pixel = XGetPixel(image, x, y);
        for (const int shift : {16, 8, 0}) rgb.push_back(static_cast<std::uint8_t>(pixel >> shift));
      }
    }
    XDestroyImage(image);
    return rgb;
  }

 private:
  template <class Event>
  void send(Event event, long mask) {
    XEvent any = {};
    std::memcpy(&any, &event, sizeof event);
    XSendEvent(display_.get(), window_, False, mask, &any);
    XSync(display_.get(), False);
  }

  ::Window find_window(::Window from) {
    char* name = nullptr;
    if (XFetchName(display_.get(), from, &name) != 0 && name != nullptr) {
      const bool is_ours = std::strcmp(name, "Hapton") == 0;
      XFree(name);
      if (is_ours) return from;
    }
    ::Window root = 0, parent = 0;
    ::Window* children = nullptr;
    unsigned count = 0;
    ::Window found = 0;
    if (XQueryTree(display_.get(), from, &root, &parent, &children, &count) != 0 && children != nullptr) {
      for (unsigned i = 0; i < count && found == 0; ++i) found = find_window(children[i]);
      XFree(children);
    }
    return found;
  }

  std::unique_ptr<Display, int (*)(Display*)> display_;
  ::Window window_ = 0;
};

}  // namespace hapton
