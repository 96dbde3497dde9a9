#include "link/session_entry.h"

namespace hapton {

std::string_view to_string(MissCause cause) noexcept {
  switch (cause) {
    case MissCause::none:
      return "none";
    case MissCause::late_wake_up:
      return "late wake-up";
    case MissCause::device_slow:
      return "device slow";
    case MissCause::work_long:
      return "work long";
    case MissCause::machine_stalled:
      return "machine stalled";
  }
  return "unknown";
}

std::string_view to_string(SessionFault fault) noexcept {
  switch (fault) {
    case SessionFault::none:
      return "none";
    case SessionFault::command_timeout:
      return "command-timeout";
    case SessionFault::not_finite:
      return "not-finite";
    case SessionFault::rejected_future:
      return "rejected-future";
    case SessionFault::clamped:
      return "clamped";
    case SessionFault::stalled:
      return "stalled";
    case SessionFault::device:
      return "device";
    case SessionFault::overrun:
      return "overrun";
    case SessionFault::speed:
      return "speed";
    case SessionFault::position:
      return "position";
    case SessionFault::jump:
      return "jump";
    case SessionFault::thermal:
      return "thermal";
    case SessionFault::torque:
      return "torque";
    case SessionFault::energy:
      return "energy";
  }
  return "unknown";
}

}  // namespace hapton
