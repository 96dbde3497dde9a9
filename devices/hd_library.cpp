#include "devices/hd_library.h"

#include <fmt/core.h>

#include <array>
#include <type_traits>
#include <vector>

#include "devices/vendor_library.h"

namespace hapton::hd {
namespace {

struct KnownError {
  Enum code;
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array<KnownError, 22> kErrors = {{
    {0x100, "HD_INVALID_ENUM", ""},
    {0x101, "HD_INVALID_VALUE", ""},
    {kInvalidOperation, "HD_INVALID_OPERATION", ""},
    {0x103, "HD_INVALID_INPUT_TYPE", ""},
    {kBadHandle, "HD_BAD_HANDLE", ""},
    {kWarmMotors, "HD_WARM_MOTORS", "do not press against hard surfaces until the motors have cooled"},
    {0x201, "HD_EXCEEDED_MAX_FORCE", "set a tighter --max-force"},
    {0x202, "HD_EXCEEDED_MAX_FORCE_IMPULSE", "set a tighter --max-slew"},
    {0x203, "HD_EXCEEDED_MAX_VELOCITY", "move the stylus more slowly"},
    {kForceError, "HD_FORCE_ERROR", ""},
    {kDeviceFault, "HD_DEVICE_FAULT", "check its power and cable"},
    {kDeviceAlreadyInitiated, "HD_DEVICE_ALREADY_INITIATED",
     "it is in use by another program or by another device of io_node; end that first"},
    {kCommError, "HD_COMM_ERROR", "check its cable, its power and the permissions of its port (hapton doctor)"},
    {kCommConfigError, "HD_COMM_CONFIG_ERROR", "set it up with the vendor's Touch_Setup; the device's name must be the one given there"},
    {kTimerError, "HD_TIMER_ERROR", "the library could not get its timer; other real-time programs may hold it"},
    {0x400, "HD_ILLEGAL_BEGIN", ""},
    {0x401, "HD_ILLEGAL_END", ""},
    {0x402, "HD_FRAME_ERROR", ""},
    {0x500, "HD_INVALID_PRIORITY", ""},
    {0x501, "HD_SCHEDULER_FULL", ""},
    {kInvalidLicense, "HD_INVALID_LICENSE", "install the OpenHaptics licence of this machine"},
    {kSuccess, "HD_SUCCESS", ""},
}};

const KnownError* find_error(Enum code) {
  for (const KnownError& known : kErrors) {
    if (known.code == code) return &known;
  }
  return nullptr;
}

}  // namespace

std::string name_of_error(Enum code) {
  const KnownError* known = find_error(code);
  return known != nullptr ? fmt::format("{} (0x{:03x})", known->name, code) : fmt::format("error 0x{:03x}", code);
}

std::string_view remedy_for_error(Enum code) {
  const KnownError* known = find_error(code);
  return known != nullptr ? known->remedy : std::string_view();
}

void forget_errors(const Library& hd) noexcept {
  // A bound, in case the queue never gets empty.
  constexpr int kMax = 64;
  for (int n = 0; n < kMax && hd.get_error().code != kSuccess; ++n) {
  }
}

Result<Library> load(const std::string& file) {
  const auto library = VendorLibrary::open(kOpenHaptics, file);
  if (!library) return tl::unexpected(library.error());
  Library hd;
  hd.file = library->file();
  std::vector<std::string_view> missing;
  library->require("hdInitDevice", hd.init_device, missing);
  library->require("hdDisableDevice", hd.disable_device, missing);
  library->require("hdMakeCurrentDevice", hd.make_current_device, missing);
  library->require("hdBeginFrame", hd.begin_frame, missing);
  library->require("hdEndFrame", hd.end_frame, missing);
  library->require("hdGetError", hd.get_error, missing);
  library->require("hdGetErrorString", hd.get_error_string, missing);
  library->require("hdEnable", hd.enable, missing);
  library->require("hdGetIntegerv", hd.get_integers, missing);
  library->require("hdGetFloatv", hd.get_floats, missing);
  library->require("hdGetDoublev", hd.get_doubles, missing);
  library->require("hdGetString", hd.get_string, missing);
  library->require("hdSetDoublev", hd.set_doubles, missing);
  library->require("hdCheckCalibration", hd.check_calibration, missing);
  library->require("hdUpdateCalibration", hd.update_calibration, missing);
  library->require("hdStartScheduler", hd.start_scheduler, missing);
  library->require("hdStopScheduler", hd.stop_scheduler, missing);
  library->require("hdScheduleAsynchronous", hd.schedule_asynchronous, missing);
  library->require("hdUnschedule", hd.unschedule, missing);
  if (!missing.empty()) return tl::unexpected(missing_symbols(*library, missing));
  return hd;
}

}  // namespace hapton::hd
