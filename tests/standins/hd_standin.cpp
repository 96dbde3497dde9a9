// Our own library with the binary interface of libHD, as far as it is used, and a point mass in place of a device. It keeps the rules of
// the real one where breaking them would matter: forces are set in frames, frames are of the scheduler's thread, one device once.
#include <chrono>
#include <cstring>
#include <deque>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/standins/board.h"
#include "tests/standins/point_mass.h"

namespace {

using namespace hapton::standin;

constexpr unsigned kDevice = 7;
constexpr unsigned kNoDevice = 0xFFFFFFFF;
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

class Hardware {
 public:
  unsigned open(const char* name) {
    board_ = &BoardFile::of_environment();
    constexpr const char* kNames[] = {"Default Device", "Default PHANToM", nullptr, "Left Hand"};
    const char* known = kNames[board().known_name];
    const bool is_known = name == nullptr || known == nullptr ? name == known : std::strcmp(name, known) == 0;
    if (board().open_error != 0) return refuse(board().open_error);
    if (!is_known || board().is_plugged == 0) return refuse(kCommError);
    if (is_open_) return refuse(kAlreadyInitiated);
    is_open_ = true;
    updates_ = 0;
    mass_.place(board());
    ++board().opened;
    return kDevice;
  }

  void close(unsigned device) {
    if (device != kDevice || !is_open_) {
      report(kBadHandle);
      return;
    }
    is_open_ = false;
    ++board().closed;
  }

  void begin_frame(unsigned device) {
    if (device != kDevice || !is_open_ || in_frame_ || std::this_thread::get_id() != scheduler_.load()) ++board().wrong_calls;
    in_frame_ = true;
  }

  void end_frame(unsigned device) {
    if (device != kDevice || !in_frame_) {
      ++board().wrong_calls;
      report(kIllegalEnd);
    }
    in_frame_ = false;
    PointMass::note_force(board(), force_n_, torque_mnm_, is_calibrated());
    if (board().is_plugged == 0) report(kCommError);
    if (board().error_each_tick != 0) report(board().error_each_tick);
    if (const unsigned once = board().error_once.exchange(0); once != 0) report(once);
  }

  void set(unsigned what, const double* values) {
    if (!in_frame_ || std::this_thread::get_id() != scheduler_.load()) ++board().wrong_calls;
    auto& into = what == 0x2700 ? force_n_ : torque_mnm_;
    if (what != 0x2700 && (what != 0x2701 || board().output_dof != 6)) return report(kInvalidEnum);
    std::copy(values, values + 3, into.begin());
  }

  void get(unsigned what, double* values) {
    const auto& p = mass_.position_m();
    switch (what) {
      case 0x2050:
        for (std::size_t axis = 0; axis < 3; ++axis) values[axis] = 1e3 * p[axis];
        return;
      case 0x2052: {
        const auto rows = PointMass::rotation(board());
        for (std::size_t column = 0; column < 3; ++column) {
          for (std::size_t row = 0; row < 3; ++row) values[4 * column + row] = rows[row][column];
          values[4 * column + 3] = 0.0;
          values[12 + column] = 1e3 * p[column];
        }
        values[15] = 1.0;
        return;
      }
      case 0x2551: {
        constexpr double kBoxMm[] = {-80, -40, -35, 80, 80, 35};
        std::copy(std::begin(kBoxMm), std::end(kBoxMm), values);
        return;
      }
      case 0x2602:
        *values = 1.26;
        return;
      case 0x2603:
        *values = board().max_force_n;
        return;
      case 0x2604:
        *values = 0.88;
        return;
      case 0x2605:
        for (int motor = 0; motor < 6; ++motor) values[motor] = motor == 2 ? board().motor_temperature.load() : 0.1;
        return;
      default:
        report(kInvalidEnum);
    }
  }

  void get(unsigned what, int* values) {
    if (what == 0x2000) {
      *values = board().buttons;
    } else if (what == 0x2554) {
      *values = board().output_dof;
    } else if (what == 0x2555) {
      *values = board().calibration_style;
    } else {
      report(kInvalidEnum);
    }
  }

  unsigned calibration() { return 0x5000U + static_cast<unsigned>(is_calibrated() ? 0 : board().calibration.load()); }

  void update_calibration(unsigned style) {
    ++board().calibration_updates;
    board().last_update_style = static_cast<int>(style);
    if (board().updates_until_good != 0 && ++updates_ >= board().updates_until_good) board().calibration = 0;
  }

  void enable(unsigned capability) { board().enabled |= 1 << (capability & 0xFU); }

  void start() {
    if (thread_.joinable()) return;
    ends_ = false;
    thread_ = std::thread([this] { run(); });
    board().is_running = 1;
  }

  void stop() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
    thread_ = {};
    board().is_running = 0;
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
    if (errors_.empty()) return {0, 0, kDevice};
    const ErrorInfo error = errors_.front();
    errors_.pop_front();
    return error;
  }

  void report(unsigned code) {
    const std::lock_guard lock(error_mutex_);
    if (errors_.size() < 32) errors_.push_back({code, -42, kDevice});
  }

  const char* text(unsigned what) {
    switch (what) {
      case 0x2501:
        return "Stand-in Touch";
      case 0x2504:
        return "SN-0042";
      default:
        return "";
    }
  }

 private:
  Board& board() { return *board_; }
  bool is_calibrated() { return board().calibration == 0; }
  unsigned refuse(unsigned code) {
    report(code);
    return kNoDevice;
  }

  void run() {
    scheduler_ = std::this_thread::get_id();
    auto tick = std::chrono::steady_clock::now();
    while (!ends_) {
      tick += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(tick);
      tick = std::max(tick, std::chrono::steady_clock::now() - std::chrono::milliseconds(5));
      if (board().slow_us > 0) std::this_thread::sleep_for(std::chrono::microseconds(board().slow_us));
      if (board().stands_still != 0) continue;
      mass_.step(board(), force_n_, 1e-3);
      const std::lock_guard lock(mutex_);
      for (const Scheduled& s : scheduled_) s.callback(s.data);
      ++board().ticks;
    }
  }

  std::atomic<Board*> board_ = &BoardFile::of_environment();
  PointMass mass_;
  std::array<double, 3> force_n_ = {};
  std::array<double, 3> torque_mnm_ = {};
  int updates_ = 0;
  bool is_open_ = false;
  bool in_frame_ = false;
  std::atomic<bool> ends_{false};
  std::thread thread_;
  std::atomic<std::thread::id> scheduler_;
  std::mutex mutex_;
  std::vector<Scheduled> scheduled_;
  unsigned long last_id_ = 0;
  std::mutex error_mutex_;
  std::deque<ErrorInfo> errors_;
};

// Lives as long as the process: nobody knows who calls last.
Hardware& hardware() {
  static auto* const all = new Hardware;
  return *all;
}

}  // namespace

extern "C" {

unsigned hdInitDevice(const char* name) { return hardware().open(name); }
void hdDisableDevice(unsigned device) { hardware().close(device); }
void hdMakeCurrentDevice(unsigned) {}
void hdBeginFrame(unsigned device) { hardware().begin_frame(device); }
void hdEndFrame(unsigned device) { hardware().end_frame(device); }
#ifndef HAPTON_STANDIN_IS_OLD
ErrorInfo hdGetError() { return hardware().take_error(); }
#endif
const char* hdGetErrorString(unsigned) { return "the stand-in's own words"; }
void hdEnable(unsigned capability) { hardware().enable(capability); }
void hdGetIntegerv(unsigned what, int* values) { hardware().get(what, values); }
void hdGetFloatv(unsigned what, float* values) {
  if (what == 0x2505) *values = 4.5F;
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
