// Stand-in for Force Dimension's libdrd and, without the drd functions, for libdhd: those functions that Hapton calls, on a simulated point
// mass. The test controls and observes it through shared memory (board.h).
#include <chrono>
#include <thread>

#include "tests/standins/board.h"
#include "tests/standins/point_mass.h"

namespace {

using namespace hapton::standin;
using Clock = std::chrono::steady_clock;

constexpr char kDevice = 3;
constexpr int kFalcon = 60;  // DHD_DEVICE_FALCON

class Hardware {
 public:
  // Reads the environment again: a test may have made another board meanwhile.
  int count() {
    board_ = &BoardFile::of_environment();
    return board().is_plugged;
  }

  int open(char index) {
    if (count() == 0 || index != 0 || is_open_) return -1;
    is_open_ = true;
    calibration_updates_ = 0;
    mass_.place(board());
    force_ = torque_ = {};
    last_step_time_ = Clock::now();
    ++board().opened;
    board().enabled = 0;
    return kDevice;
  }

  int close(char id) {
    if (id != kDevice || !is_open_) return reject_call();
    is_open_ = false;
    ++board().closed;
    return 0;
  }

  // Result of a call that transfers data: what the test set (0: success), or -1 while unplugged.
  int exchange(char id) {
    if (id != kDevice || !is_open_) return reject_call();
    if (board().slow_us > 0) std::this_thread::sleep_for(std::chrono::microseconds(board().slow_us));
    return board().is_plugged != 0 ? board().result.load() : -1;
  }

  int position(double* x, double* y, double* z, char id) {
    const auto now = Clock::now();
    // A step is at most 5 ms: after a pause of the test, the explicit integration would be unstable with the whole time.
    const double passed_s = std::min(std::chrono::duration<double>(now - last_step_time_).count(), 0.005);
    last_step_time_ = now;
    const bool is_force_on = board().enabled != 0 && board().force_off_cause == 0;
    mass_.step(board(), is_force_on ? force_ : std::array<double, 3>{}, passed_s);
    ++board().ticks;
    *x = mass_.position_m()[0];
    *y = mass_.position_m()[1];
    *z = mass_.position_m()[2];
    return exchange(id);
  }

  int set_force(const std::array<double, 3>& force, const std::array<double, 3>& torque, char id) {
    force_ = force;
    torque_ = torque;
    PointMass::note_force(board(), force, torque, board().calibration == 0);
    // A Falcon calibrates while the user moves it, as long as the host sends forces.
    if (board().system_type == kFalcon) calibrate();
    return exchange(id);
  }

  void calibrate() {
    if (board().updates_until_good != 0 && ++calibration_updates_ >= board().updates_until_good) board().calibration = 0;
    ++board().calibration_updates;
  }

  int reject_call() {
    ++board().wrong_calls;
    return -1;
  }

  Board& board() { return *board_; }

 private:
  std::atomic<Board*> board_ = &BoardFile::of_environment();
  PointMass mass_;
  std::array<double, 3> force_ = {};
  std::array<double, 3> torque_ = {};
  Clock::time_point last_step_time_;
  int calibration_updates_ = 0;
  bool is_open_ = false;
};

Hardware& hardware() {
  static auto* const instance = new Hardware;
  return *instance;
}

}  // namespace

extern "C" {

int dhdGetDeviceCount() { return hardware().count(); }
int dhdOpenID(char index) { return hardware().open(index); }
int dhdClose(char id) { return hardware().close(id); }
int dhdEnableForce(unsigned char on, char) {
  hardware().board().enabled = on;
  if (on != 0) hardware().board().force_off_cause = 0;
  return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char id) { return hardware().position(x, y, z, id); }
int dhdGetOrientationFrame(double (*frame)[3], char id) {
  const auto rows = PointMass::rotation(hardware().board());
  const double scale = hardware().board().frame_scale;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) frame[row][column] = scale * rows[row][column];
  }
  return hardware().board().failing_call == 1 ? -1 : hardware().exchange(id);
}
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double, char id) {
  const int result = hardware().set_force({fx, fy, fz}, {tx, ty, tz}, id);
  return hardware().board().failing_call == 2 ? -1 : result;
}
unsigned dhdGetButtonMask(char) { return static_cast<unsigned>(hardware().board().buttons.load()); }
int dhdGetSystemType(char) { return hardware().board().system_type; }
const char* dhdGetSystemName(char) { return "stand-in omega"; }
int dhdGetSerialNumber(unsigned short* number, char) {
  const int serial = hardware().board().serial;
  *number = static_cast<unsigned short>(serial);
  return serial >= 0 ? 0 : -1;
}
int dhdGetStatus(int* status, char) {
  std::fill(status, status + 17, 0);  // indices from the documentation of the SDK, intentionally not from dhd_library.h
  const Board& board = hardware().board();
  if (board.failing_call == 3) return -1;
  status[0] = board.has_power;
  status[1] = board.is_connected != 0 ? board.is_plugged.load() : 0;
  status[3] = board.calibration != 0;
  status[5] = board.enabled != 0 && board.force_off_cause == 0 ? 1 : 0;
  status[14] = board.force_off_cause;
  return 0;
}
// The error of the last call, as in the SDK: any other call may replace it.
const char* dhdErrorGetLastStr() { return hardware().board().kept_forces != 0 ? "the stand-in's own words" : "no error"; }
int dhdSetWatchdog(unsigned char units, char) {
  hardware().board().watchdog = units;
  return 0;
}
int dhdSetGravityCompensation(int, char) { return 0; }
#ifndef HAPTON_STANDIN_IS_WITHOUT_DRD
int drdOpenID(char index) { return hardware().open(index); }
bool drdIsInitialized(char) { return hardware().board().calibration == 0; }
int drdAutoInit(char) {
  hardware().board().moved_by_itself = 1;
  hardware().calibrate();
  return hardware().board().calibration == 0 || hardware().board().claims_success != 0 ? 0 : -1;
}
int drdStop(bool keeps_forces, char) {
  hardware().board().kept_forces = keeps_forces ? 1 : 0;
  return 0;
}
#endif
}
