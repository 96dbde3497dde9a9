#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "devices/device.h"

namespace hapton::dhd {

// The part of the Force Dimension SDK (DHD and DRD, 3.x) that we use, declared from its documented binary interface: plain C calls, the
// device's number last. SI units; a result of -1 is an error, 1 and 2 are not. Axes: x towards the user, y to the right, z up.
using Id = char;

constexpr int kOk = 0;
constexpr int kTimeguard = 1;       // called again too soon: the library returned the previous result
constexpr int kMotorSaturated = 2;  // a motor has reached its maximum

// Indices into the array that get_status fills; newer releases fill more of it. kStatusReset: 1 while the device waits in its RESET
// mode to be calibrated.
constexpr std::size_t kStatusPower = 0, kStatusConnected = 1, kStatusStarted = 2, kStatusReset = 3, kStatusForce = 5, kStatusBrake = 6;
constexpr std::size_t kStatusError = 9, kStatusTimeguard = 11, kStatusForceOffCause = 14;
using Status = std::array<int, 32>;

// Novint Falcon: a type number of the library's header.
constexpr int kFalcon = 60;

// Time without a force after which the watchdog of the firmware turns the motors off, in units of 125 us.
constexpr unsigned char kWatchdogUnits = 255;  // 31.9 ms, its maximum; a servo at 250 Hz needs 4 ms

// Values of kStatusForceOffCause that latch in the firmware until the program enables the force again.
constexpr int kOffByVelocityThreshold = 2, kOffByWatchdog = 3;
// Why the firmware released the force, for a log line: "its force button", "the arm moved faster than its velocity threshold", ...
std::string_view name_of_force_off_cause(int cause);

// Limits of a device by its type, because the library does not report them. Our own conservative values, to be checked against the maker's
// data sheet; unknown types get low ones.
struct System {
  int type;
  std::string_view name;
  double max_force_n;
  double continuous_force_n;
  double max_torque_nm;
  Vec3 half_workspace_m;  // half the sides of the workspace, along the axes of W
};
const System& find_system(int type);

// The library's functions. Those of DRD are null if only libdhd was loaded.
struct Library {
  int (*get_device_count)() = nullptr;
  int (*open_id)(Id index) = nullptr;
  int (*close)(Id) = nullptr;
  int (*enable_force)(unsigned char, Id) = nullptr;
  int (*get_position)(double*, double*, double*, Id) = nullptr;
  int (*get_orientation_frame)(double (*)[3], Id) = nullptr;
  int (*set_force_and_torque_and_gripper_force)(double, double, double, double, double, double, double, Id) = nullptr;
  unsigned (*get_button_mask)(Id) = nullptr;
  int (*get_system_type)(Id) = nullptr;
  const char* (*get_system_name)(Id) = nullptr;
  int (*get_status)(int*, Id) = nullptr;
  const char* (*get_last_error_text)() = nullptr;
  int (*set_watchdog)(unsigned char, Id) = nullptr;
  int (*set_gravity_compensation)(int, Id) = nullptr;
  int (*get_serial_number)(unsigned short*, Id) = nullptr;  // null: the library has no such function

  int (*drd_open_id)(Id index) = nullptr;
  bool (*drd_is_initialized)(Id) = nullptr;
  int (*drd_auto_init)(Id) = nullptr;
  int (*drd_stop)(bool force_on, Id) = nullptr;

  std::string file;
};

// Loads libdrd, otherwise libdhd, by their usual names, or only the given file. Error: one line, see VendorLibrary. RT: set-up only.
Result<Library> load(const std::string& file = "");

}  // namespace hapton::dhd
