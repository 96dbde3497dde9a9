#include "devices/force_dimension_device.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <atomic>
#include <charconv>
#include <cmath>
#include <thread>
#include <utility>

#include "devices/dhd_library.h"
#include "devices/vendor_device.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr std::int64_t kPeriodNs = kNanosecondsPerMillisecond;
// 10 times a second: soon enough for a person who reads the status, and each check is a USB transfer.
constexpr int kTicksPerStatusCheck = 100;
constexpr std::int64_t kReopenEveryNs = kNanosecondsPerSecond;
constexpr std::int64_t kLogPeriodNs = 10 * kNanosecondsPerSecond;  // between two log lines about the same state
constexpr int kMaxFailuresInARow = 10;                             // failed calls; so many lost USB packets mean an unplugged cable
// These values are our choice, see docs/vendor-devices.md.
constexpr double kPeakS = 10.0;
constexpr double kMaxSpeedMPerS = 5.0;
constexpr double kMaxStiffnessNPerM = 2000.0;

// The device's axes are x towards the user, y right, z up.
Vec3 to_w(const Vec3& v) { return {v.y(), v.z(), v.x()}; }
Vec3 from_w(const Vec3& v) { return {v.z(), v.x(), v.y()}; }

class ForceDimensionDevice final : public VendorDevice {
 public:
  ForceDimensionDevice(dhd::Library library, int index, std::optional<RealtimeSettings> realtime, const ForceDimensionOptions& options)
      : dhd_(std::move(library)), index_(index), realtime_(realtime), options_(options) {}
  ~ForceDimensionDevice() override;

  Result<void> open();
  void start() {
    thread_ = start_thread([this] { run(); });
  }

  std::string_view name() const noexcept override { return "forcedimension"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceCondition condition() const noexcept override {
    return {model_, serial_, {}, exchange_.reading().is_calibrated, exchange_.reading().motor_temperature};
  }

 private:
  std::string last_error() const;
  std::string read_serial() const;
  // False also if the device does not report whether it is calibrated.
  bool is_initialized() const;

  // Called by the thread only.
  void run();
  void calibrate();
  void wait_for_hand_calibration();
  void notice_calibration();
  bool wait_warning();
  bool tick(std::int64_t now_ns);
  void check_status(std::int64_t now_ns);
  void log_away(std::int64_t now_ns, const std::string& why);
  void try_to_reopen(std::int64_t now_ns);
  void publish(DeviceStatus status, std::int64_t now_ns);

  const dhd::Library dhd_;
  const int index_;
  const std::optional<RealtimeSettings> realtime_;
  const ForceDimensionOptions options_;
  DeviceLimits limits_;
  std::string model_, serial_;
  int type_ = 0;
  SteadyClock clock_;

  std::thread thread_;
  std::atomic<bool> ends_{false};

  // Used by the thread only, once it runs.
  dhd::Id id_ = -1;
  bool is_open_ = false;
  DeviceExchange::Reading reading_;
  int failures_ = 0;
  int ticks_to_check_ = 0;
  bool is_force_off_ = false;
  std::int64_t next_reopen_ns_ = 0;
  std::int64_t next_log_ns_ = 0;
  std::string logged_reason_;  // why it could not be opened again, as logged last
};

ForceDimensionDevice::~ForceDimensionDevice() {
  ends_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
  if (!is_open_) return;
  dhd_.set_force_and_torque_and_gripper_force(0, 0, 0, 0, 0, 0, 0, id_);
  dhd_.close(id_);
}

std::string ForceDimensionDevice::last_error() const {
  const char* said = dhd_.get_last_error_text();
  return said != nullptr && *said != '\0' ? said : "the library gives no reason";
}

// Empty if the library does not report it.
std::string ForceDimensionDevice::read_serial() const {
  unsigned short number = 0;
  const bool is_known = dhd_.get_serial_number != nullptr && dhd_.get_serial_number(&number, id_) >= 0;
  return is_known ? fmt::format("{}", number) : "";
}

Result<void> ForceDimensionDevice::open() {
  const int count = dhd_.get_device_count();
  if (count <= index_) {
    return fail("the Force Dimension SDK finds {} devices, and --device-id is number {}; check power, cable and udev rule (hapton doctor)",
                std::max(count, 0), index_);
  }
  const auto index = static_cast<dhd::Id>(index_);
  const int id = dhd_.drd_open_id != nullptr ? dhd_.drd_open_id(index) : dhd_.open_id(index);
  if (id < 0) return fail("the Force Dimension SDK cannot open device {}: {}; is another program using it?", index_, last_error());
  id_ = static_cast<dhd::Id>(id);
  is_open_ = true;
  const int type = dhd_.get_system_type(id_);
  if (!model_.empty() && (type != type_ || read_serial() != serial_)) {
    dhd_.close(id_);
    is_open_ = false;
    return fail("another device is connected than before; connect serial {} again, or restart io_node", serial_.empty() ? "?" : serial_);
  }
  type_ = type;
  const dhd::System& system = dhd::find_system(type);
  if (model_.empty()) {
    const char* said = dhd_.get_system_name(id_);
    model_ = said != nullptr && *said != '\0' ? said : "unknown model";
    serial_ = read_serial();
    limits_ = {.max_force_n = system.max_force_n,
               .max_slew_n_per_s = system.max_force_n / kForceRiseS,
               .max_stiffness_n_per_m = kMaxStiffnessNPerM,
               .workspace_min_m = -system.half_workspace_m,
               .workspace_max_m = system.half_workspace_m,
               .max_torque_nm = system.max_torque_nm,
               .max_torque_slew_nm_per_s = system.max_torque_nm / kForceRiseS,
               .continuous_force_n = system.continuous_force_n,
               .peak_s = kPeakS,
               .max_speed_m_per_s = kMaxSpeedMPerS};
    if (system.name.empty()) log_warning("{} (type {}) is unknown: force limited to {:.0f} N", model_, type, system.max_force_n);
  }
  dhd_.set_gravity_compensation(1, id_);
  dhd_.set_watchdog(dhd::kWatchdogUnits, id_);
  failures_ = 0;
  ticks_to_check_ = 0;
  is_force_off_ = false;
  return {};
}

void ForceDimensionDevice::publish(DeviceStatus status, std::int64_t now_ns) {
  reading_.status = status;
  reading_.sample.time_ns = now_ns;
  exchange_.publish(reading_);
}

void ForceDimensionDevice::run() {
  // An error is ignored: the servo's thread lacks the same rights, and logs that.
  if (realtime_) (void)enter_realtime(*realtime_);
  std::int64_t tick_ns = clock_.now_ns();
  calibrate();
  while (!ends_.load(std::memory_order_relaxed)) {
    tick_ns = std::max(tick_ns + kPeriodNs, clock_.now_ns());
    clock_.sleep_until_ns(tick_ns);
    const std::int64_t now_ns = clock_.now_ns();
    if (!is_open_) {
      publish(DeviceStatus::away, now_ns);
      try_to_reopen(now_ns);
    } else if (tick(now_ns)) {
      failures_ = 0;
    } else if (++failures_ >= kMaxFailuresInARow) {
      log_away(now_ns, last_error());
    }
  }
}

bool ForceDimensionDevice::is_initialized() const {
  if (dhd_.drd_is_initialized != nullptr) return dhd_.drd_is_initialized(id_);
  dhd::Status status = {};
  return dhd_.get_status(status.data(), id_) >= 0 && status[dhd::kStatusReset] == 0;
}

// The arm will move by itself: warns the person who holds it first. False: the device is being closed.
bool ForceDimensionDevice::wait_warning() {
  log_warning("{} will move by itself to calibrate: release it and keep clear", model_);
  const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * options_.warning_before_moving_s);
  for (std::int64_t now_ns = clock_.now_ns(); now_ns < end_ns; now_ns = clock_.now_ns()) {
    publish(DeviceStatus::calibrating, now_ns);
    if (ends_.load(std::memory_order_relaxed)) return false;
    clock_.sleep_until_ns(now_ns + 10 * kPeriodNs);
  }
  return true;
}

void ForceDimensionDevice::calibrate() {
  reading_.is_calibrated = is_initialized();
  if (!reading_.is_calibrated && type_ == dhd::kFalcon) return wait_for_hand_calibration();
  if (!reading_.is_calibrated) {
    if (dhd_.drd_auto_init == nullptr) {
      log_warning(
          "{}: calibrate: hold its end-effector in its rest position, or use the vendor's own program; {} cannot do it without libdrd",
          model_, dhd_.file);
      return;
    }
    if (!wait_warning()) return;
    if (dhd_.drd_auto_init(id_) < 0) {
      const std::string why = last_error();  // before the next call changes it
      if (dhd_.drd_stop != nullptr) dhd_.drd_stop(false, id_);
      log_error("{} could not calibrate: {}; remove obstacles and start again", model_, why);
      return;
    }
    reading_.is_calibrated = is_initialized();
    if (!reading_.is_calibrated) {
      if (dhd_.drd_stop != nullptr) dhd_.drd_stop(false, id_);
      return log_error("{} has moved to calibrate, but is still not calibrated; start again", model_);
    }
    log_info("{} is calibrated", model_);
  }
  // Switches libdrd's position control off and leaves the forces on.
  if (dhd_.drd_stop != nullptr) dhd_.drd_stop(true, id_);
  dhd_.enable_force(1, id_);
  if (dhd_.set_watchdog(dhd::kWatchdogUnits, id_) < 0) log_warning("{}: its watchdog could not be set: {}", model_, last_error());
}

// A Falcon cannot move by itself to calibrate: the user must pull its grip out and push it in once, while the program polls it.
void ForceDimensionDevice::wait_for_hand_calibration() {
  log_warning("{}: calibrate: pull the grip all the way out and push it all the way in", model_);
  failures_ = 0;
  while (!ends_.load(std::memory_order_relaxed) && !is_initialized()) {
    const std::int64_t now_ns = clock_.now_ns();
    const bool is_there = dhd_.set_force_and_torque_and_gripper_force(0, 0, 0, 0, 0, 0, 0, id_) >= 0;
    failures_ = is_there ? 0 : failures_ + 1;
    if (failures_ >= kMaxFailuresInARow) return log_away(now_ns, last_error());
    publish(DeviceStatus::calibrating, now_ns);
    clock_.sleep_until_ns(now_ns + kPeriodNs);
  }
  if (ends_.load(std::memory_order_relaxed)) return;
  reading_.is_calibrated = true;
  log_info("{} is calibrated", model_);
  dhd_.enable_force(1, id_);
}

// Without libdrd a person or another program calibrates the device, while this program runs.
void ForceDimensionDevice::notice_calibration() {
  if (dhd_.drd_auto_init != nullptr || !is_initialized()) return;
  log_info("{} is calibrated", model_);
  calibrate();
}

// False if the device did not reply.
bool ForceDimensionDevice::tick(std::int64_t now_ns) {
  Vec3 p = Vec3::Zero();
  double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (dhd_.get_position(&p.x(), &p.y(), &p.z(), id_) < 0 || dhd_.get_orientation_frame(frame, id_) < 0) return false;
  reading_.sample.p_WD = to_w(p);  // may be non-finite: the governor checks it
  Eigen::Matrix3d r;
  for (int row = 0; row < 3; ++row) {
    const Vec3 in_device(frame[row][0], frame[row][1], frame[row][2]);
    // A change of basis from the device's axes to those of W permutes rows and columns alike.
    r.row((row + 2) % 3) = to_w(in_device).transpose();
  }
  if (r.allFinite() && std::abs(r.determinant() - 1.0) < 0.1) reading_.sample.q_WT = Quat(r).normalized();
  reading_.sample.buttons = dhd_.get_button_mask(id_);
  // While the firmware keeps the force off, the ramp must not advance: it begins when the force is on again.
  const Wrench wrench = is_force_off_ ? Wrench{} : exchange_.wrench(now_ns);
  const Vec3 f = from_w(wrench.force_n);
  const Vec3 t = from_w(wrench.torque_nm);
  if (dhd_.set_force_and_torque_and_gripper_force(f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), 0.0, id_) < 0) return false;
  if (--ticks_to_check_ <= 0) {
    ticks_to_check_ = kTicksPerStatusCheck;
    check_status(now_ns);
  }
  if (!is_open_) return true;
  publish(reading_.is_calibrated ? DeviceStatus::ready : DeviceStatus::calibrating, now_ns);
  return true;
}

void ForceDimensionDevice::check_status(std::int64_t now_ns) {
  dhd::Status status = {};
  if (dhd_.get_status(status.data(), id_) < 0) return;
  if (status[dhd::kStatusConnected] == 0) return log_away(now_ns, "it reports that it is not connected");
  if (!reading_.is_calibrated) return notice_calibration();
  const bool was_off = std::exchange(is_force_off_, status[dhd::kStatusForce] == 0);
  if (!is_force_off_) return;
  exchange_.restart_ramp();
  if (!was_off && now_ns >= next_log_ns_) {
    next_log_ns_ = now_ns + kLogPeriodNs;
    log_warning("{} has released its force: {}; it returns by itself, or with the device's force button", model_,
                status[dhd::kStatusPower] == 0 ? "its power is off" : dhd::name_of_force_off_cause(status[dhd::kStatusForceOffCause]));
  }
  // Ends a cut-off that the firmware has latched. The force button is the user's to press.
  const int cause = status[dhd::kStatusForceOffCause];
  if (cause == dhd::kOffByVelocityThreshold || cause == dhd::kOffByWatchdog) dhd_.enable_force(1, id_);
}

void ForceDimensionDevice::log_away(std::int64_t now_ns, const std::string& why) {
  log_warning("{} is disconnected ({}); trying to reconnect", model_, why);
  dhd_.close(id_);
  is_open_ = false;
  logged_reason_.clear();
  next_reopen_ns_ = now_ns + kReopenEveryNs / 4;
  publish(DeviceStatus::away, now_ns);
}

void ForceDimensionDevice::try_to_reopen(std::int64_t now_ns) {
  if (now_ns < next_reopen_ns_) return;
  next_reopen_ns_ = now_ns + kReopenEveryNs;
  if (const auto opened = open(); !opened) {
    if (std::exchange(logged_reason_, opened.error().what) != opened.error().what)
      log_info("{}: trying to reconnect: {}", model_, opened.error().what);
    return;
  }
  log_info("{} is back", model_);
  calibrate();
}

Result<int> index_of(const std::string& id) {
  int index = 0;
  const auto read = std::from_chars(id.data(), id.data() + id.size(), index);
  if (!id.empty() && (read.ec != std::errc() || read.ptr != id.data() + id.size() || index < 0 || index > 31)) {
    return fail("--device-id of a Force Dimension device is its number, from 0, not '{}'", id);
  }
  return index;
}

}  // namespace

Result<std::unique_ptr<Device>> make_force_dimension(const DeviceSettings& settings, const ForceDimensionOptions& options) {
  const auto index = index_of(settings.id);
  if (!index) return tl::unexpected(index.error());
  auto library = dhd::load(options.library_file);
  if (!library) return tl::unexpected(library.error());
  auto device = std::make_unique<ForceDimensionDevice>(std::move(*library), *index, settings.realtime, options);
  if (const auto opened = device->open(); !opened) return tl::unexpected(opened.error());
  const DeviceCondition condition = device->condition();
  log_info("Force Dimension SDK: {}, serial {}, at most {:.2f} N", condition.model, condition.serial.empty() ? "?" : condition.serial,
           device->limits().max_force_n);
  device->start();
  return device;
}

}  // namespace hapton
