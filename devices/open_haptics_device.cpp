#include "devices/open_haptics_device.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "devices/hd_session.h"
#include "devices/vendor_device.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr double kMPerMm = 1e-3;
constexpr double kMNmPerNm = 1e3;
constexpr auto kPollPeriod = std::chrono::milliseconds(20);  // how often the keeper checks errors and calibration
constexpr std::int64_t kReopenEveryNs = kNanosecondsPerSecond;
constexpr std::int64_t kReopenBesideOthersEveryNs = 10 * kNanosecondsPerSecond;  // each attempt interrupts the others
constexpr std::int64_t kLogPeriodNs = 10 * kNanosecondsPerSecond;                // between two log lines about the same state
// The library's scheduler calls a thousand times a second. Without a call for this time, it or the device has stopped.
constexpr std::int64_t kSchedulerTimeoutNs = kNanosecondsPerSecond / 2;
constexpr int kTicksPerConditionCheck = 100;                                   // of temperature and calibration
constexpr std::int64_t kForceErrorPauseNs = 100 * kNanosecondsPerMillisecond;  // without force after a force error
constexpr int kMaxErrorsATick = 8;                                             // taken from the library's queue: bounds the work of a tick
// The library does not report these: conservative values of our own, see docs/vendor-devices.md.
constexpr double kPeakS = 5.0;             // how long the motors hold the maximum force
constexpr double kContinuousShare = 0.25;  // of the maximum force
constexpr double kMaxTorqueNm = 0.1;
constexpr double kMaxSpeedMPerS = 5.0;

std::string text_or(const char* text, const char* fallback) { return text != nullptr && *text != '\0' ? text : fallback; }

enum class Calibration : std::uint8_t { unknown, good, updating, at_neutral_pose, in_inkwell, by_moving };

// What a person has to do now.
std::string_view instruction_for(Calibration calibration) {
  switch (calibration) {
    case Calibration::unknown:
    case Calibration::good:
      return "";
    case Calibration::updating:
      return "calibrating: move the stylus about a little";
    case Calibration::at_neutral_pose:
      return "calibrate: hold the arm in its neutral pose, all links at right angles, and press the stylus button (where there is none, "
             "calibrate with the vendor's own program first)";
    case Calibration::in_inkwell:
      return "calibrate: put the stylus into its inkwell and leave it there until calibration is reported done";
    case Calibration::by_moving:
      return "calibrate: move the stylus slowly through its whole workspace";
  }
  return "";
}

class OpenHapticsDevice final : public VendorDevice {
 public:
  OpenHapticsDevice(std::shared_ptr<hd::Session> session, std::string device_name)
      : session_(std::move(session)), hd_(session_->hd()), device_name_(std::move(device_name)) {}
  ~OpenHapticsDevice() override;

  Result<void> open();
  void start_keeper() {
    keeper_ = start_thread([this] { keep(); });
  }

  std::string_view name() const noexcept override { return "openhaptics"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceCondition condition() const noexcept override;

 private:
  // Set-up: the first time on the caller's thread, later on the keeper's.
  Result<void> set_up();
  Result<void> read_limits();
  std::string read_model() const { return text_or(hd_.get_string(hd::kModelType), "unknown model"); }
  std::string read_serial() const { return text_or(hd_.get_string(hd::kSerialNumber), ""); }
  void read_texts();
  double get(hd::Enum what, double fallback) const;

  // The scheduler's thread.
  static hd::Enum on_tick(void* self) noexcept;
  void tick() noexcept;
  void read_frame(DeviceSample& sample) noexcept;
  void write_frame(const Wrench& wrench) noexcept;
  void check_condition() noexcept;
  void check_calibration() noexcept;
  void collect_errors(std::int64_t now_ns) noexcept;

  // The keeper's thread: work that may take long, and log lines.
  void keep();
  void log_calibration();
  void log_errors(std::int64_t now_ns);
  bool is_lost(std::int64_t now_ns) const;
  void reopen(std::int64_t now_ns);

  std::shared_ptr<hd::Session> session_;
  const hd::Library& hd_;
  std::string device_name_;
  DeviceLimits limits_;
  Vec3 middle_m_ = Vec3::Zero();
  std::string model_, serial_, firmware_;
  hd::Enum calibration_styles_ = 0;
  bool has_torque_ = false;
  SteadyClock clock_;

  hd::Handle device_ = hd::kInvalidHandle;  // set before the first tick
  hd::Session::Attached attached_;

  // The scheduler's thread.
  DeviceExchange::Reading reading_;
  int ticks_to_check_ = 0;
  std::int64_t pause_until_ns_ = 0;

  // From the scheduler's thread to the keeper's.
  std::atomic<std::int64_t> ticked_ns_{0};
  std::atomic<Calibration> calibration_{Calibration::unknown};
  std::atomic<hd::Enum> force_error_{hd::kSuccess};
  std::atomic<hd::Enum> device_error_{hd::kSuccess};

  std::thread keeper_;
  std::atomic<bool> ends_{false};
  bool is_open_ = false;  // used by the keeper's thread
  Calibration logged_calibration_ = Calibration::unknown;
  std::int64_t next_reopen_ns_ = 0;
  std::int64_t next_error_log_ns_ = 0;
  std::string logged_reason_;  // why it could not be opened again, as logged last
};

OpenHapticsDevice::~OpenHapticsDevice() {
  ends_.store(true, std::memory_order_relaxed);
  if (keeper_.joinable()) keeper_.join();
  if (is_open_) session_->detach(attached_);
}

DeviceCondition OpenHapticsDevice::condition() const noexcept {
  const DeviceExchange::Reading& newest = exchange_.reading();
  return {model_, serial_, firmware_, newest.is_calibrated, newest.motor_temperature};
}

double OpenHapticsDevice::get(hd::Enum what, double fallback) const {
  double value = fallback;
  hd_.get_doubles(what, &value);
  return hd_.get_error().code == hd::kSuccess && std::isfinite(value) ? value : fallback;
}

void OpenHapticsDevice::read_texts() {
  model_ = read_model();
  serial_ = read_serial();
  // OpenHaptics 3.0 documents a float; without one the text stays empty.
  float firmware = 0.0F;
  hd_.get_floats(hd::kFirmwareVersion, &firmware);
  firmware_ = hd_.get_error().code == hd::kSuccess && firmware > 0.0F ? fmt::format("{:g}", firmware) : "";
  hd::forget_errors(hd_);
}

Result<void> OpenHapticsDevice::read_limits() {
  std::array<double, 6> box_mm = {};
  hd_.get_doubles(hd::kUsableWorkspace, box_mm.data());
  const Vec3 low_m = kMPerMm * Vec3(box_mm[0], box_mm[1], box_mm[2]);
  const Vec3 high_m = kMPerMm * Vec3(box_mm[3], box_mm[4], box_mm[5]);
  const double max_n = get(hd::kNominalMaxForce, 0.0);
  const bool is_box_sane = low_m.allFinite() && high_m.allFinite() && ((high_m - low_m).array() > 0.01).all();
  if (!is_box_sane || max_n <= 0.0 || max_n > 100.0) {
    return fail(
        "OpenHaptics reports an impossible workspace or force for {}: {:g} x {:g} x {:g} m and {:g} N; set it up again (Touch_Setup)",
        model_, high_m.x() - low_m.x(), high_m.y() - low_m.y(), high_m.z() - low_m.z(), max_n);
  }
  middle_m_ = 0.5 * (low_m + high_m);
  limits_.workspace_min_m = low_m - middle_m_;
  limits_.workspace_max_m = high_m - middle_m_;
  limits_.max_force_n = max_n;
  limits_.max_slew_n_per_s = max_n / kForceRiseS;
  // A continuous force of zero would count as the maximum force, as for motors that need no thermal limit.
  const double continuous_n = get(hd::kNominalMaxContinuousForce, 0.0);
  limits_.continuous_force_n = continuous_n > 0.0 ? std::min(continuous_n, max_n) : kContinuousShare * max_n;
  limits_.peak_s = kPeakS;
  limits_.max_speed_m_per_s = kMaxSpeedMPerS;
  // The library reports N/mm.
  limits_.max_stiffness_n_per_m = 1e3 * std::clamp(get(hd::kNominalMaxStiffness, 0.5), 0.1, 5.0);
  int output_dof = 3;
  hd_.get_integers(hd::kOutputDof, &output_dof);
  has_torque_ = output_dof == 6;
  limits_.max_torque_nm = has_torque_ ? kMaxTorqueNm : 0.0;
  limits_.max_torque_slew_nm_per_s = limits_.max_torque_nm / kForceRiseS;
  return {};
}

// Pre: this device is the current one, and the scheduler is stopped.
Result<void> OpenHapticsDevice::set_up() {
  const bool is_first = model_.empty();
  // Another device has another workspace and other limits, which the person at the scene does not expect.
  if (!is_first && (read_model() != model_ || read_serial() != serial_)) {
    return fail("another device is connected than before; connect serial {} again, or restart io_node", serial_.empty() ? "?" : serial_);
  }
  if (is_first) read_texts();
  if (const auto limits = is_first ? read_limits() : Result<void>(); !limits) return limits;
  int styles = 0;
  hd_.get_integers(hd::kCalibrationStyle, &styles);
  calibration_styles_ = static_cast<hd::Enum>(styles);
  for (const hd::Enum capability : {hd::kForceOutput, hd::kMaxForceClamping, hd::kSoftwareForceLimit, hd::kForceRamping}) {
    hd_.enable(capability);
    // Not all devices have all of these; a device without force output exerts no force, which is harmless.
    hd::forget_errors(hd_);
  }
  reading_ = {};
  ticks_to_check_ = 0;
  pause_until_ns_ = 0;
  device_error_ = hd::kSuccess;
  calibration_ = logged_calibration_ = Calibration::unknown;
  ticked_ns_ = clock_.now_ns();
  return {};
}

Result<void> OpenHapticsDevice::open() {
  const auto attached = session_->attach(
      device_name_,
      [this](hd::Handle device) {
        device_ = device;
        return set_up();
      },
      on_tick, this);
  if (!attached) return tl::unexpected(attached.error());
  attached_ = *attached;
  is_open_ = true;
  return {};
}

hd::Enum OpenHapticsDevice::on_tick(void* self) noexcept {
  static_cast<OpenHapticsDevice*>(self)->tick();
  return hd::kCallbackContinue;
}

void OpenHapticsDevice::tick() noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  // After a pause the force ramps up again: opening or closing another device stops the scheduler for all devices.
  if (now_ns - reading_.sample.time_ns > DeviceExchange::kDriverTimeoutNs) exchange_.restart_ramp();
  reading_.sample.time_ns = now_ns;
  hd_.make_current_device(device_);
  hd_.begin_frame(device_);
  read_frame(reading_.sample);
  if (--ticks_to_check_ <= 0) {
    ticks_to_check_ = kTicksPerConditionCheck;
    check_condition();
  }
  write_frame(now_ns < pause_until_ns_ ? Wrench{} : exchange_.wrench(now_ns));
  hd_.end_frame(device_);
  collect_errors(now_ns);
  if (device_error_.load(std::memory_order_relaxed) != hd::kSuccess) {
    reading_.status = DeviceStatus::away;
  } else {
    reading_.status = reading_.is_calibrated ? DeviceStatus::ready : DeviceStatus::calibrating;
  }
  exchange_.publish(reading_);
  ticked_ns_.store(now_ns, std::memory_order_release);
}

// The library gives positions in mm, and the transform column by column.
void OpenHapticsDevice::read_frame(DeviceSample& sample) noexcept {
  std::array<double, 3> position_mm = {};
  position_mm.fill(std::numeric_limits<double>::quiet_NaN());  // remains if the library gives no position
  std::array<double, 16> transform = {};
  int buttons = 0;
  hd_.get_doubles(hd::kCurrentPosition, position_mm.data());
  hd_.get_doubles(hd::kCurrentTransform, transform.data());
  hd_.get_integers(hd::kCurrentButtons, &buttons);
  // May be non-finite: the governor checks it.
  sample.p_WD = kMPerMm * Vec3(position_mm[0], position_mm[1], position_mm[2]) - middle_m_;
  const Eigen::Map<const Eigen::Matrix4d> x(transform.data());
  const Eigen::Matrix3d r = x.topLeftCorner<3, 3>();
  if (r.allFinite() && std::abs(r.determinant() - 1.0) < 0.1) sample.q_WT = Quat(r).normalized();
  sample.buttons = static_cast<std::uint32_t>(buttons) & 0xFU;
}

void OpenHapticsDevice::write_frame(const Wrench& wrench) noexcept {
  const std::array<double, 3> force_n = {wrench.force_n.x(), wrench.force_n.y(), wrench.force_n.z()};
  hd_.set_doubles(hd::kCurrentForce, force_n.data());
  if (!has_torque_) return;
  const Vec3 t = kMNmPerNm * wrench.torque_nm;
  const std::array<double, 3> torque_mnm = {t.x(), t.y(), t.z()};
  hd_.set_doubles(hd::kCurrentTorque, torque_mnm.data());
}

void OpenHapticsDevice::check_condition() noexcept {
  std::array<double, 16> temperatures = {};
  temperatures.fill(-1.0);
  hd_.get_doubles(hd::kMotorTemperature, temperatures.data());
  double warmest = -1.0;
  for (const double t : temperatures) warmest = std::isfinite(t) ? std::max(warmest, t) : warmest;
  reading_.motor_temperature = warmest;
  check_calibration();
}

void OpenHapticsDevice::check_calibration() noexcept {
  const hd::Enum result = hd_.check_calibration();
  if (result == hd::kCalibrationOk) {
    calibration_.store(Calibration::good, std::memory_order_relaxed);
    reading_.is_calibrated = true;
    return;
  }
  reading_.is_calibrated = false;
  const bool needs_update = result == hd::kCalibrationNeedsUpdate;
  const bool needs_user = needs_update || result == hd::kCalibrationNeedsManualInput;  // else the check itself failed
  const bool is_button_down = reading_.sample.buttons != 0;
  if ((calibration_styles_ & hd::kStyleAuto) != 0) {
    if (needs_update) hd_.update_calibration(hd::kStyleAuto);
    calibration_.store(needs_update ? Calibration::updating : Calibration::by_moving, std::memory_order_relaxed);
  } else if ((calibration_styles_ & hd::kStyleInkwell) != 0) {
    if (needs_update) hd_.update_calibration(hd::kStyleInkwell);
    calibration_.store(Calibration::in_inkwell, std::memory_order_relaxed);
  } else {
    // Only the user knows the neutral pose: the button makes the present pose the neutral one.
    if (is_button_down && needs_user) hd_.update_calibration(hd::kStyleEncoderReset);
    calibration_.store(Calibration::at_neutral_pose, std::memory_order_relaxed);
  }
}

// Takes the errors of this frame from the library's queue, of many errors only some in each tick.
void OpenHapticsDevice::collect_errors(std::int64_t now_ns) noexcept {
  for (int n = 0; n < kMaxErrorsATick; ++n) {
    const hd::ErrorInfo error = hd_.get_error();
    if (error.code == hd::kSuccess) return;
    if (hd::is_force_error(error.code)) {
      pause_until_ns_ = now_ns + kForceErrorPauseNs;
      exchange_.restart_ramp();
      force_error_.store(error.code, std::memory_order_relaxed);
    } else if (hd::is_device_error(error.code)) {
      device_error_.store(error.code, std::memory_order_relaxed);
    }
  }
}

void OpenHapticsDevice::keep() {
  while (!ends_.load(std::memory_order_relaxed)) {
    std::this_thread::sleep_for(kPollPeriod);
    const std::int64_t now_ns = clock_.now_ns();
    log_calibration();
    log_errors(now_ns);
    if (is_lost(now_ns)) reopen(now_ns);
  }
}

void OpenHapticsDevice::log_calibration() {
  const Calibration calibration = calibration_.load(std::memory_order_relaxed);
  if (!is_open_ || calibration == logged_calibration_) return;
  logged_calibration_ = calibration;
  if (calibration == Calibration::good) {
    log_info("{} is calibrated", model_);
  } else {
    log_warning("{}: {}", model_, instruction_for(calibration));
  }
}

void OpenHapticsDevice::log_errors(std::int64_t now_ns) {
  if (now_ns < next_error_log_ns_) return;
  const hd::Enum error = force_error_.exchange(hd::kSuccess, std::memory_order_relaxed);
  if (error == hd::kSuccess) return;
  next_error_log_ns_ = now_ns + kLogPeriodNs;
  const std::string_view remedy = hd::remedy_for_error(error);
  log_warning("{} reports {}; its force was released{}{}", model_, hd::name_of_error(error), remedy.empty() ? "" : "; ", remedy);
}

bool OpenHapticsDevice::is_lost(std::int64_t now_ns) const {
  if (!is_open_) return true;
  return device_error_.load(std::memory_order_relaxed) != hd::kSuccess ||
         now_ns - ticked_ns_.load(std::memory_order_acquire) > kSchedulerTimeoutNs;
}

void OpenHapticsDevice::reopen(std::int64_t now_ns) {
  if (is_open_) {
    const hd::Enum error = device_error_.load(std::memory_order_relaxed);
    log_warning("{} is disconnected ({}); trying to reconnect", model_,
                error != hd::kSuccess ? hd::name_of_error(error) : "its scheduler has stopped");
    session_->detach(attached_);
    is_open_ = false;
    logged_reason_.clear();
    // The scheduler no longer runs: this is the last reading until the device is back.
    reading_.status = DeviceStatus::away;
    exchange_.publish(reading_);
    next_reopen_ns_ = now_ns + kReopenEveryNs / 4;
  }
  if (now_ns < next_reopen_ns_) return;
  next_reopen_ns_ = now_ns + (session_->has_users() ? kReopenBesideOthersEveryNs : kReopenEveryNs);
  if (const auto opened = open(); opened) {
    log_info("{} is back", model_);
  } else if (std::exchange(logged_reason_, opened.error().what) != opened.error().what) {
    log_info("{}: trying to reconnect: {}", model_, opened.error().what);
  }
}

}  // namespace

Result<std::unique_ptr<Device>> make_open_haptics(const DeviceSettings& settings, const std::string& library_file) {
  auto session = hd::Session::join(library_file);
  if (!session) return tl::unexpected(session.error());
  auto device = std::make_unique<OpenHapticsDevice>(std::move(*session), settings.id);
  if (const auto opened = device->open(); !opened) return tl::unexpected(opened.error());
  const DeviceCondition condition = device->condition();
  log_info("OpenHaptics: {}, serial {}, firmware {}, at most {:.2f} N", condition.model, condition.serial.empty() ? "?" : condition.serial,
           condition.firmware.empty() ? "?" : condition.firmware, device->limits().max_force_n);
  device->start_keeper();
  return device;
}

}  // namespace hapton
