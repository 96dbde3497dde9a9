#include "devices/dhd_library.h"

#include <vector>

#include "devices/vendor_library.h"

namespace hapton::dhd {

std::string_view name_of_force_off_cause(int cause) {
  constexpr std::array<std::string_view, 7> kNames = {"none",
                                                      "its force button",
                                                      "the arm moved faster than its velocity threshold",
                                                      "its watchdog: no force had come in time",
                                                      "the library",
                                                      "its USB cable was pulled",
                                                      "its dead-man switch"};
  return cause >= 0 && static_cast<std::size_t>(cause) < kNames.size() ? kNames[static_cast<std::size_t>(cause)] : "an unknown cause";
}

const System& find_system(int type) {
  static const std::array<System, 12> systems = {{
      {33, "omega.3", 12.0, 6.0, 0.0, {0.08, 0.055, 0.08}},
      {34, "omega.6", 12.0, 6.0, 0.0, {0.08, 0.055, 0.08}},
      {36, "omega.6 (left)", 12.0, 6.0, 0.0, {0.08, 0.055, 0.08}},
      {35, "omega.7", 12.0, 6.0, 0.0, {0.08, 0.055, 0.08}},
      {37, "omega.7 (left)", 12.0, 6.0, 0.0, {0.08, 0.055, 0.08}},
      {63, "delta.3", 20.0, 10.0, 0.0, {0.18, 0.13, 0.18}},
      {104, "sigma.7", 20.0, 10.0, 0.4, {0.095, 0.065, 0.095}},
      {105, "sigma.7 (left)", 20.0, 10.0, 0.4, {0.095, 0.065, 0.095}},
      {108, "lambda.7", 20.0, 10.0, 0.0, {0.12, 0.1, 0.1}},
      {109, "lambda.7 (left)", 20.0, 10.0, 0.0, {0.12, 0.1, 0.1}},
      {kFalcon, "Falcon", 8.0, 4.0, 0.0, {0.05, 0.05, 0.05}},
      {-1, "", 3.0, 1.5, 0.0, {0.05, 0.05, 0.05}},
  }};
  for (const System& system : systems) {
    if (system.type == type) return system;
  }
  return systems.back();
}

Result<Library> load(const std::string& file) {
  const auto library = VendorLibrary::open(kForceDimension, file);
  if (!library) return tl::unexpected(library.error());
  Library dhd;
  dhd.file = library->file();
  std::vector<std::string_view> missing;
  library->require("dhdGetDeviceCount", dhd.get_device_count, missing);
  library->require("dhdOpenID", dhd.open_id, missing);
  library->require("dhdClose", dhd.close, missing);
  library->require("dhdEnableForce", dhd.enable_force, missing);
  library->require("dhdGetPosition", dhd.get_position, missing);
  library->require("dhdGetOrientationFrame", dhd.get_orientation_frame, missing);
  library->require("dhdSetForceAndTorqueAndGripperForce", dhd.set_force_and_torque_and_gripper_force, missing);
  library->require("dhdGetButtonMask", dhd.get_button_mask, missing);
  library->require("dhdGetSystemType", dhd.get_system_type, missing);
  library->require("dhdGetSystemName", dhd.get_system_name, missing);
  library->require("dhdGetStatus", dhd.get_status, missing);
  library->require("dhdErrorGetLastStr", dhd.get_last_error_text, missing);
  library->require("dhdSetWatchdog", dhd.set_watchdog, missing);
  library->require("dhdSetGravityCompensation", dhd.set_gravity_compensation, missing);
  if (!missing.empty()) return tl::unexpected(missing_symbols(*library, missing));
  dhd.get_serial_number = library->find<int(unsigned short*, Id)>("dhdGetSerialNumber");
  dhd.drd_open_id = library->find<int(Id)>("drdOpenID");
  dhd.drd_is_initialized = library->find<bool(Id)>("drdIsInitialized");
  dhd.drd_auto_init = library->find<int(Id)>("drdAutoInit");
  dhd.drd_stop = library->find<int(bool, Id)>("drdStop");
  return dhd;
}

}  // namespace hapton::dhd
