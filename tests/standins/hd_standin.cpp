// A library with the functions of libHD that Hapton uses, with the same binary interface, and with a point mass instead of a device. It
// checks those rules of libHD whose violation would matter: forces are set in frames, frames run in the scheduler's thread, a device is
// opened once, and all threads share one current device.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/standins/board.h"
#include "tests/standins/point_mass.h"

namespace {

using namespace hapton::standin;

constexpr unsigned kFirstDevice = 7;
constexpr unsigned kNoDevice = 0xFFFFFFFF;
// Parameters of hdGet... and hdSet..., from the documentation of the SDK, intentionally not from hd_library.h.
constexpr unsigned kButtons = 0x2000, kPosition = 0x2050, kTransform = 0x2052;
constexpr unsigned kModel = 0x2501, kSerialNumber = 0x2504, kFirmwareVersion = 0x2505;
constexpr unsigned kUsableWorkspace = 0x2551, kOutputDof = 0x2554, kCalibrationStyle = 0x2555;
constexpr unsigned kMaxStiffness = 0x2602, kMaxForce = 0x2603, kContinuousForce = 0x2604, kMotorTemperature = 0x2605;
constexpr unsigned kForce = 0x2700, kTorque = 0x2701;
constexpr unsigned kCalibrationOk = 0x5000;
constexpr int kInternalCode = -42;  // of every error; Hapton only prints it
constexpr unsigned kCommError = 0x302, kAlreadyInitiated = 0x301, kBadHandle = 0x104, kInvalidEnum = 0x100, kIllegalEnd = 0x401;

struct ErrorInfo {
  unsigned code;
  int internal_code;
  unsigned device;
};

struct Scheduled {
  unsigned long id;
  unsigned (*callback)(void*);
  void* data;
};

// One device: its state in the library, and its point mass.
struct Unit {
  unsigned handle = 0;
  std::atomic<Board*> shared{nullptr};
  PointMass mass;
  std::array<double, 3> force_n = {};
  std::array<double, 3> torque_mnm = {};
  int updates = 0;
  bool is_open = false;
  bool in_frame = false;

  Board& board() const { return *shared; }
  bool is_calibrated() const { return board().calibration == 0; }
};

class Hardware {
 public:
  Hardware() {
    for (std::size_t n = 0; n < units_.size(); ++n) {
      units_[n].handle = kFirstDevice + static_cast<unsigned>(n);
      units_[n].shared = &BoardFile::of_environment();
    }
  }

  unsigned open(const char* name) {
    Unit& unit = find(name);
    unit.shared = &BoardFile::of_environment(&unit == units_.data() ? kBoardVariable : kSecondBoardVariable);
    if (unit.board().open_error != 0) return refuse(unit.board(), unit.board().open_error);
    if (!is_known(unit, name) || unit.board().is_plugged == 0) return refuse(unit.board(), kCommError);
    if (unit.is_open) return refuse(unit.board(), kAlreadyInitiated);
    // All threads share one current device: opening a device within another's frame would end that frame.
    if (is_running_) ++unit.board().wrong_calls;
    unit.is_open = true;
    unit.updates = 0;
    unit.mass.place(unit.board());
    unit.force_n = unit.torque_mnm = {};
    ++unit.board().opened;
    current_ = &unit;
    return unit.handle;
  }

  void make_current(unsigned device) {
    if (Unit* unit = find(device)) current_ = unit;
  }

  void close(unsigned device) {
    Unit* unit = find(device);
    if (unit == nullptr || !unit->is_open) return report(kBadHandle);
    if (is_running_) ++unit->board().wrong_calls;
    unit->is_open = false;
    ++unit->board().closed;
  }

  void begin_frame(unsigned device) {
    Unit* unit = find(device);
    if (unit == nullptr) return report(kBadHandle);
    if (unit != current_ || !unit->is_open || unit->in_frame || !is_scheduler()) ++unit->board().wrong_calls;
    unit->in_frame = true;
  }

  void end_frame(unsigned device) {
    Unit* unit = find(device);
    if (unit == nullptr || !unit->in_frame) return report(kIllegalEnd);
    if (unit != current_) ++unit->board().wrong_calls;
    unit->in_frame = false;
    Board& board = unit->board();
    PointMass::note_force(board, unit->force_n, unit->torque_mnm, unit->is_calibrated());
    if (board.is_plugged == 0) report(kCommError);
    if (board.error_each_tick != 0) report(board.error_each_tick);
    if (const unsigned once = board.error_once.exchange(0); once != 0) report(once);
  }

  void set(unsigned what, const double* values) {
    Unit& unit = *current_;
    if (!unit.in_frame || !is_scheduler()) ++unit.board().wrong_calls;
    if (what != kForce && (what != kTorque || unit.board().output_dof != 6)) return report(kInvalidEnum);
    std::copy(values, values + 3, (what == kForce ? unit.force_n : unit.torque_mnm).begin());
  }

  void get(unsigned what, double* values) {
    const Board& board = current_->board();
    const auto& p = current_->mass.position_m();
    switch (what) {
      case kPosition:
        for (std::size_t axis = 0; axis < 3; ++axis) values[axis] = 1e3 * p[axis];
        return;
      case kTransform: {
        const auto rows = PointMass::rotation(board);
        for (std::size_t column = 0; column < 3; ++column) {
          for (std::size_t row = 0; row < 3; ++row) values[4 * column + row] = rows[row][column];
          values[4 * column + 3] = 0.0;
          values[12 + column] = 1e3 * p[column];
        }
        values[15] = 1.0;
        return;
      }
      case kUsableWorkspace: {
        const double box_mm[] = {board.box_low_mm, -40, -35, 80, 80, 35};
        std::copy(std::begin(box_mm), std::end(box_mm), values);
        return;
      }
      case kMaxStiffness:
        *values = board.max_stiffness;
        return;
      case kMaxForce:
        *values = board.max_force_n;
        return;
      case kContinuousForce:
        *values = board.continuous_force_n;
        return;
      case kMotorTemperature:
        for (int motor = 0; motor < 6; ++motor) values[motor] = motor == 2 ? board.motor_temperature.load() : 0.1;
        return;
      default:
        report(kInvalidEnum);
    }
  }

  void get(unsigned what, int* values) {
    const Board& board = current_->board();
    if (what == kButtons) {
      *values = board.buttons;
    } else if (what == kOutputDof) {
      *values = board.output_dof;
    } else if (what == kCalibrationStyle) {
      *values = board.calibration_style;
    } else {
      report(kInvalidEnum);
    }
  }

  void get_firmware(float* value) {
    if (current_->board().has_texts == 0) return report(kInvalidEnum);
    *value = 4.5F;
  }

  unsigned calibration() {
    const Unit& unit = *current_;
    return kCalibrationOk + static_cast<unsigned>(unit.is_calibrated() ? 0 : unit.board().calibration.load());
  }

  void update_calibration(unsigned style) {
    Unit& unit = *current_;
    Board& board = unit.board();
    ++board.calibration_updates;
    board.last_update_style = static_cast<int>(style);
    if (board.updates_until_good != 0 && ++unit.updates >= board.updates_until_good) board.calibration = 0;
  }

  void enable(unsigned capability) { current_->board().enabled |= 1 << (capability & 0xFU); }

  void start() {
    if (is_running_) return;
    ends_ = false;
    is_running_ = true;
    thread_ = std::thread([this] { run(); });
    units_[0].board().is_running = 1;
  }

  void stop() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
    is_running_ = false;
    units_[0].board().is_running = 0;
  }

  unsigned long schedule(unsigned (*callback)(void*), void* data) {
    const std::lock_guard lock(mutex_);
    scheduled_.push_back({++last_id_, callback, data});
    return last_id_;
  }

  void unschedule(unsigned long id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(scheduled_, [&](const Scheduled& s) { return s.id == id; });
  }

  ErrorInfo take_error() {
    const std::lock_guard lock(error_mutex_);
    if (const unsigned endless = units_[0].board().endless_error; endless != 0) return {endless, kInternalCode, kFirstDevice};
    if (errors_.empty()) return {0, 0, kFirstDevice};
    const ErrorInfo error = errors_.front();
    errors_.pop_front();
    return error;
  }

  void report(unsigned code) {
    const std::lock_guard lock(error_mutex_);
    if (errors_.size() < 32) errors_.push_back({code, kInternalCode, kFirstDevice});
  }

  const char* text(unsigned what) const {
    if (current_->board().has_texts == 0) return nullptr;
    switch (what) {
      case kModel:
        return "Stand-in Touch";
      case kSerialNumber:
        return current_->board().is_another == 0 ? "SN-0042" : "SN-0043";
      default:
        return "";
    }
  }

 private:
  // The second device exists only if it has its own board.
  Unit& find(const char* name) {
    const bool is_second = name != nullptr && std::strcmp(name, "Second Device") == 0 && std::getenv(kSecondBoardVariable) != nullptr;
    return units_[is_second ? 1 : 0];
  }
  Unit* find(unsigned device) {
    for (Unit& unit : units_) {
      if (unit.handle == device) return &unit;
    }
    return nullptr;
  }
  bool is_known(const Unit& unit, const char* name) const {
    constexpr const char* kNames[] = {"Default Device", "Default PHANToM", nullptr, "Left Hand"};
    const char* known = kNames[unit.board().known_name];
    if (&unit != units_.data()) return true;
    return name == nullptr || known == nullptr ? name == known : std::strcmp(name, known) == 0;
  }
  bool is_scheduler() const { return std::this_thread::get_id() == scheduler_.load(); }
  unsigned refuse(const Board& board, unsigned code) {
    ++units_[0].board().refused;
    for (int n = 0; n < board.errors_a_refusal; ++n) report(code);
    return kNoDevice;
  }

  void run() {
    scheduler_ = std::this_thread::get_id();
    auto tick = std::chrono::steady_clock::now();
    while (!ends_) {
      tick += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(tick);
      tick = std::max(tick, std::chrono::steady_clock::now() - std::chrono::milliseconds(5));
      const Board& first = units_[0].board();
      if (first.slow_us > 0) std::this_thread::sleep_for(std::chrono::microseconds(first.slow_us));
      if (first.stands_still != 0) continue;
      for (Unit& unit : units_) {
        if (unit.is_open) unit.mass.step(unit.board(), unit.force_n, 1e-3);
      }
      const std::lock_guard lock(mutex_);
      for (const Scheduled& s : scheduled_) s.callback(s.data);
      for (Unit& unit : units_) {
        if (unit.is_open) ++unit.board().ticks;
      }
    }
  }

  std::array<Unit, 2> units_;
  Unit* current_ = units_.data();
  std::atomic<bool> is_running_{false};
  std::atomic<bool> ends_{false};
  std::thread thread_;
  std::atomic<std::thread::id> scheduler_;
  std::mutex mutex_;
  std::vector<Scheduled> scheduled_;
  unsigned long last_id_ = 0;
  std::mutex error_mutex_;
  std::deque<ErrorInfo> errors_;
};

// It is never destroyed, because nobody knows which call of the library is the last one.
Hardware& hardware() {
  static auto* const instance = new Hardware;
  return *instance;
}

}  // namespace

extern "C" {

unsigned hdInitDevice(const char* name) { return hardware().open(name); }
void hdDisableDevice(unsigned device) { hardware().close(device); }
void hdMakeCurrentDevice(unsigned device) { hardware().make_current(device); }
void hdBeginFrame(unsigned device) { hardware().begin_frame(device); }
void hdEndFrame(unsigned device) { hardware().end_frame(device); }
#ifndef HAPTON_STANDIN_IS_OLD
ErrorInfo hdGetError() { return hardware().take_error(); }
#endif
const char* hdGetErrorString(unsigned) { return "the stand-in's own words"; }
void hdEnable(unsigned capability) { hardware().enable(capability); }
void hdGetIntegerv(unsigned what, int* values) { hardware().get(what, values); }
void hdGetFloatv(unsigned what, float* values) {
  if (what == kFirmwareVersion) hardware().get_firmware(values);
}
void hdGetDoublev(unsigned what, double* values) { hardware().get(what, values); }
const char* hdGetString(unsigned what) { return hardware().text(what); }
void hdSetDoublev(unsigned what, const double* values) { hardware().set(what, values); }
unsigned hdCheckCalibration() { return hardware().calibration(); }
void hdUpdateCalibration(unsigned style) { hardware().update_calibration(style); }
void hdStartScheduler() { hardware().start(); }
void hdStopScheduler() { hardware().stop(); }
unsigned long hdScheduleAsynchronous(unsigned (*callback)(void*), void* data, unsigned short) {
  return hardware().schedule(callback, data);
}
void hdUnschedule(unsigned long id) { hardware().unschedule(id); }
}
