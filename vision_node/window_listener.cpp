#include "vision_node/window_listener.h"

#include <utility>

#include <vtkCallbackCommand.h>
#include <vtkNew.h>

namespace hapton {

WindowListener::WindowListener(vtkRenderWindow* window) {
  // VTK warns that the library with its own mouse styles is not linked; we bring our own.
  vtkObject::GlobalWarningDisplayOff();
  interactor_ = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  vtkObject::GlobalWarningDisplayOn();
  interactor_->SetRenderWindow(window);
  interactor_->SetInteractorStyle(nullptr);
  interactor_->EnableRenderOff();
  vtkNew<vtkCallbackCommand> hearing;
  hearing->SetClientData(this);
  hearing->SetCallback([](vtkObject*, unsigned long event, void* self, void*) { static_cast<WindowListener*>(self)->hear(event); });
  for (const unsigned long event :
       {vtkCommand::KeyPressEvent, vtkCommand::LeftButtonPressEvent, vtkCommand::LeftButtonReleaseEvent, vtkCommand::MiddleButtonPressEvent,
        vtkCommand::MiddleButtonReleaseEvent, vtkCommand::RightButtonPressEvent, vtkCommand::RightButtonReleaseEvent,
        vtkCommand::MouseMoveEvent, vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent, vtkCommand::ExitEvent,
        vtkCommand::RenderEvent, vtkCommand::ExposeEvent, vtkCommand::ConfigureEvent}) {
    interactor_->AddObserver(event, hearing);
  }
  interactor_->Initialize();
}

void WindowListener::hear(unsigned long event) {
  using Kind = WindowEvent::Kind;
  using Button = WindowEvent::Button;
  WindowEvent heard;
  const int* at = interactor_->GetEventPosition();
  heard.x_px = at[0];
  heard.y_px = at[1];
  heard.shift = interactor_->GetShiftKey() != 0;
  switch (event) {
    case vtkCommand::KeyPressEvent:
      heard.kind = Kind::key;
      heard.key = interactor_->GetKeyCode();
      break;
    case vtkCommand::LeftButtonPressEvent:
      heard.kind = Kind::press;
      heard.button = Button::left;
      break;
    case vtkCommand::LeftButtonReleaseEvent:
      heard.kind = Kind::release;
      heard.button = Button::left;
      break;
    case vtkCommand::MiddleButtonPressEvent:
      heard.kind = Kind::press;
      heard.button = Button::middle;
      break;
    case vtkCommand::MiddleButtonReleaseEvent:
      heard.kind = Kind::release;
      heard.button = Button::middle;
      break;
    case vtkCommand::RightButtonPressEvent:
      heard.kind = Kind::press;
      heard.button = Button::right;
      break;
    case vtkCommand::RightButtonReleaseEvent:
      heard.kind = Kind::release;
      heard.button = Button::right;
      break;
    case vtkCommand::MouseMoveEvent:
      heard.kind = Kind::move;
      break;
    case vtkCommand::MouseWheelForwardEvent:
      heard.kind = Kind::wheel;
      heard.wheel = 1;
      break;
    case vtkCommand::MouseWheelBackwardEvent:
      heard.kind = Kind::wheel;
      heard.wheel = -1;
      break;
    case vtkCommand::ExitEvent:
      heard.kind = Kind::close;
      break;
    default:
      stale_ = true;
      return;
  }
  events_.push_back(heard);
}

WindowListener::~WindowListener() { interactor_->RemoveAllObservers(); }

std::vector<WindowEvent> WindowListener::poll() {
  interactor_->ProcessEvents();
  return std::exchange(events_, {});
}

bool WindowListener::take_stale() { return std::exchange(stale_, false); }

}  // namespace hapton
