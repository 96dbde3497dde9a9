#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton::hd {

// The part of the HD interface of OpenHaptics 3.0 to 3.5 that we use, declared from its documented binary interface: Linux, x86-64, plain C
// calls. Lengths mm, velocities mm/s, forces N, torques mNm, temperatures 0 .. 1.
using Handle = unsigned int;
using Boolean = unsigned char;
using Enum = unsigned int;
using Schedule = unsigned long;
using Callback = Enum (*)(void*);

struct ErrorInfo {
  Enum code;
  int internal_code;
  Handle device;
};
static_assert(sizeof(ErrorInfo) == 12, "it is returned by value");

constexpr Handle kInvalidHandle = 0xFFFFFFFF;
constexpr Enum kSuccess = 0;

// Parameters that can be read and set.
constexpr Enum kCurrentButtons = 0x2000, kCurrentSafetySwitch = 0x2001, kCurrentInkwellSwitch = 0x2002;
constexpr Enum kCurrentPosition = 0x2050, kCurrentVelocity = 0x2051, kCurrentTransform = 0x2052;
constexpr Enum kModelType = 0x2501, kDriverVersion = 0x2502, kVendor = 0x2503, kSerialNumber = 0x2504, kFirmwareVersion = 0x2505;
constexpr Enum kMaxWorkspace = 0x2550, kUsableWorkspace = 0x2551, kInputDof = 0x2553, kOutputDof = 0x2554, kCalibrationStyle = 0x2555;
constexpr Enum kNominalMaxStiffness = 0x2602, kNominalMaxForce = 0x2603, kNominalMaxContinuousForce = 0x2604, kMotorTemperature = 0x2605;
constexpr Enum kCurrentForce = 0x2700, kCurrentTorque = 0x2701;

constexpr Enum kForceOutput = 0x4000, kMaxForceClamping = 0x4001, kForceRamping = 0x4002, kSoftwareForceLimit = 0x4003;

constexpr Enum kCalibrationOk = 0x5000, kCalibrationNeedsUpdate = 0x5001, kCalibrationNeedsManualInput = 0x5002;
constexpr Enum kStyleEncoderReset = 1, kStyleAuto = 2, kStyleInkwell = 4;

constexpr Enum kInvalidOperation = 0x102, kBadHandle = 0x104;
constexpr Enum kWarmMotors = 0x200, kForceError = 0x204;
constexpr Enum kDeviceFault = 0x300, kDeviceAlreadyInitiated = 0x301, kCommError = 0x302, kCommConfigError = 0x303, kTimerError = 0x304;
constexpr Enum kInvalidLicense = 0x600;

constexpr Enum kCallbackDone = 0, kCallbackContinue = 1;
constexpr unsigned short kHighestPriority = 65535;  // the highest priority of a callback in the library's scheduler

// "HD_COMM_ERROR (0x302)", "error 0x999".
std::string name_of_error(Enum code);
// What a person can do about the error, in one line; empty: nothing is known.
std::string_view remedy_for_error(Enum code);

// An error after which the force is released for a moment, and the device goes on: 0x200 .. 0x2FF.
constexpr bool is_force_error(Enum code) { return (code & ~0xFFU) == 0x200; }
// An error after which the device has to be opened again: 0x300 .. 0x3FF, or an invalid handle.
constexpr bool is_device_error(Enum code) { return (code & ~0xFFU) == 0x300 || code == kBadHandle; }

// The functions of the library; none is null after load().
struct Library {
  Handle (*init_device)(const char* name) = nullptr;
  void (*disable_device)(Handle) = nullptr;
  void (*make_current_device)(Handle) = nullptr;
  void (*begin_frame)(Handle) = nullptr;
  void (*end_frame)(Handle) = nullptr;
  ErrorInfo (*get_error)() = nullptr;
  const char* (*get_error_string)(Enum) = nullptr;
  void (*enable)(Enum) = nullptr;
  void (*get_integers)(Enum, int*) = nullptr;
  void (*get_floats)(Enum, float*) = nullptr;
  void (*get_doubles)(Enum, double*) = nullptr;
  const char* (*get_string)(Enum) = nullptr;
  void (*set_doubles)(Enum, const double*) = nullptr;
  Enum (*check_calibration)() = nullptr;
  void (*update_calibration)(Enum style) = nullptr;
  void (*start_scheduler)() = nullptr;
  void (*stop_scheduler)() = nullptr;
  Schedule (*schedule_asynchronous)(Callback, void* data, unsigned short priority) = nullptr;
  void (*unschedule)(Schedule) = nullptr;
  std::string file;
};

// Removes the waiting errors, up to a limit, so that a defective library that returns errors without end cannot block.
void forget_errors(const Library& hd) noexcept;

// Loads libHD by its usual names, or only the given file. Error: one line, see VendorLibrary. RT: set-up only.
Result<Library> load(const std::string& file = "");

}  // namespace hapton::hd
