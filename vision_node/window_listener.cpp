#include "vision_node/window_listener.h"

#include <array>
#include <string_view>
#include <utility>

#include <vtkCallbackCommand.h>
#include <vtkNew.h>

namespace hapton {
namespace {

WindowEvent::NavigationKey find_navigation_key(const char* symbol) {
  using NavigationKey = WindowEvent::NavigationKey;
  // The names of keys in the X Window System.
  static constexpr std::array<std::pair<std::string_view, NavigationKey>, 7> kNavigationKeys = {{{"Left", NavigationKey::left},
                                                                                                 {"Right", NavigationKey::right},
                                                                                                 {"Up", NavigationKey::up},
                                                                                                 {"Down", NavigationKey::down},
                                                                                                 {"Prior", NavigationKey::page_up},
                                                                                                 {"Next", NavigationKey::page_down},
                                                                                                 {"Home", NavigationKey::home}}};
  for (const auto& [name, key] : kNavigationKeys) {
    if (symbol != nullptr && name == symbol) return key;
  }
  return NavigationKey::none;
}

}  // namespace

WindowListener::WindowListener(vtkRenderWindow* window) {
  // VTK would warn that its library of mouse styles is not linked; we do not need it, because we handle the mouse ourselves.
  vtkObject::GlobalWarningDisplayOff();
  interactor_ = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  vtkObject::GlobalWarningDisplayOn();
  interactor_->SetRenderWindow(window);
  interactor_->SetInteractorStyle(nullptr);
  interactor_->EnableRenderOff();
  vtkNew<vtkCallbackCommand> callback;
  callback->SetClientData(this);
  callback->SetCallback([](vtkObject*, unsigned long event, void* self, void*) { static_cast<WindowListener*>(self)->receive(event); });
  for (const unsigned long event :
       {vtkCommand::KeyPressEvent, vtkCommand::LeftButtonPressEvent, vtkCommand::LeftButtonReleaseEvent, vtkCommand::MiddleButtonPressEvent,
        vtkCommand::MiddleButtonReleaseEvent, vtkCommand::RightButtonPressEvent, vtkCommand::RightButtonReleaseEvent,
        vtkCommand::MouseMoveEvent, vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent, vtkCommand::ExitEvent,
        vtkCommand::RenderEvent, vtkCommand::ExposeEvent, vtkCommand::ConfigureEvent}) {
    interactor_->AddObserver(event, callback);
  }
  interactor_->Initialize();
}

void WindowListener::receive(unsigned long event) {
  using Kind = WindowEvent::Kind;
  using Button = WindowEvent::Button;
  WindowEvent received;
  const int* at = interactor_->GetEventPosition();
  received.x_px = at[0];
  received.y_px = at[1];
  received.shift = interactor_->GetShiftKey() != 0;
  received.control = interactor_->GetControlKey() != 0;
  switch (event) {
    case vtkCommand::KeyPressEvent:
      received.kind = Kind::key;
      received.key = interactor_->GetKeyCode();
      received.navigation_key = find_navigation_key(interactor_->GetKeySym());
      break;
    case vtkCommand::LeftButtonPressEvent:
      received.kind = Kind::press;
      received.button = Button::left;
      break;
    case vtkCommand::LeftButtonReleaseEvent:
      received.kind = Kind::release;
      received.button = Button::left;
      break;
    case vtkCommand::MiddleButtonPressEvent:
      received.kind = Kind::press;
      received.button = Button::middle;
      break;
    case vtkCommand::MiddleButtonReleaseEvent:
      received.kind = Kind::release;
      received.button = Button::middle;
      break;
    case vtkCommand::RightButtonPressEvent:
      received.kind = Kind::press;
      received.button = Button::right;
      break;
    case vtkCommand::RightButtonReleaseEvent:
      received.kind = Kind::release;
      received.button = Button::right;
      break;
    case vtkCommand::MouseMoveEvent:
      received.kind = Kind::move;
      break;
    case vtkCommand::MouseWheelForwardEvent:
      received.kind = Kind::wheel;
      received.wheel = 1;
      break;
    case vtkCommand::MouseWheelBackwardEvent:
      received.kind = Kind::wheel;
      received.wheel = -1;
      break;
    case vtkCommand::ExitEvent:
      received.kind = Kind::close;
      break;
    default:
      needs_redraw_ = true;
      return;
  }
  events_.push_back(received);
}

WindowListener::~WindowListener() { interactor_->RemoveAllObservers(); }

std::vector<WindowEvent> WindowListener::poll() {
  interactor_->ProcessEvents();
  return std::exchange(events_, {});
}

bool WindowListener::take_redraw_request() { return std::exchange(needs_redraw_, false); }

}  // namespace hapton
