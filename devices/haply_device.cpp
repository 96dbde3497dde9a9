#include "devices/haply_device.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <utility>

#include "devices/haply_messages.h"
#include "devices/vendor_device.h"
#include "link/http_endpoint.h"
#include "link/udp_endpoint.h"
#include "link/websocket_endpoint.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr const char* kService = "localhost";
constexpr std::uint16_t kPort = 10001;  // the default of the service
constexpr std::int64_t kCommandPeriodNs = kNanosecondsPerMillisecond;
// Connecting may wait for a service that starts; replies come once a millisecond, so half a second without one is a failure.
constexpr std::int64_t kConnectPatienceNs = 2 * kNanosecondsPerSecond;
constexpr std::int64_t kReplyPatienceNs = kNanosecondsPerSecond / 2;
constexpr std::int64_t kRetryEveryNs = kNanosecondsPerSecond;
constexpr int kMaxAbsences = 20;  // states in succession without our device, after which it counts as unplugged
constexpr const char* kRemedy = "start it (systemctl start haply-inverse-service, or open the Haply Hub), or install it from haply.co";

// The service does not report limits; these are careful values, see docs/vendor-devices.md.
DeviceLimits careful_limits() {
  DeviceLimits limits;
  limits.max_force_n = 5.0;
  limits.max_slew_n_per_s = limits.max_force_n / kForceRiseS;
  limits.max_stiffness_n_per_m = 600.0;
  limits.workspace_min_m = Vec3::Constant(-0.1);
  limits.workspace_max_m = Vec3::Constant(0.1);
  limits.continuous_force_n = 2.0;
  limits.peak_s = 5.0;
  limits.max_speed_m_per_s = 5.0;
  return limits;
}

class HaplyDevice final : public VendorDevice {
 public:
  HaplyDevice(const Address& service, std::string id, std::optional<RealtimeSettings> realtime)
      : service_(service), realtime_(realtime), id_(std::move(id)) {}
  ~HaplyDevice() override {
    ends_.store(true, std::memory_order_relaxed);
    if (thread_.joinable()) thread_.join();
  }

  // Connects to the service and finds the device.
  Result<void> open();
  void start() {
    thread_ = start_thread([this] { run(); });
  }

  std::string_view name() const noexcept override { return "haply"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceCondition condition() const noexcept override { return {model_, id_, firmware_, exchange_.reading().is_calibrated, -1.0}; }

 private:
  void run();
  Result<void> check_version(const Result<std::string>& text);
  bool tick();
  void take(const haply::State& state, std::int64_t now_ns);
  void publish(DeviceStatus status, std::int64_t now_ns);
  void look_for_service(std::int64_t now_ns);

  const Address service_;
  const std::optional<RealtimeSettings> realtime_;
  const DeviceLimits limits_ = careful_limits();
  std::string id_, model_, firmware_;
  SteadyClock clock_;
  std::thread thread_;
  std::atomic<bool> ends_{false};

  // Used by the thread alone.
  std::unique_ptr<WebSocketEndpoint> socket_;
  DeviceExchange::Reading reading_;
  std::string message_;
  std::string logged_reason_;  // why the service cannot be used, as logged last
  haply::Session session_;
  bool is_version_missing_ = false;
  bool is_scale_logged_ = false;
  int absences_ = 0;
  bool is_calibration_logged_ = false;
  std::int64_t next_try_ns_ = 0;
};

// Error: the service has another version, which would accept our messages and ignore their forces.
Result<void> HaplyDevice::check_version(const Result<std::string>& text) {
  const auto version = text ? haply::read_version(*text) : tl::unexpected(text.error());
  if (!version) {
    if (std::exchange(is_version_missing_, true)) return {};  // already logged
    log_warning("the Haply Inverse Service at {} does not report its version ({}); 3.5 is assumed", to_string(service_),
                version.error().what);
    return {};
  }
  is_version_missing_ = false;
  if (const std::string why = haply::describe_version_problem(*version); !why.empty()) {
    return fail("the Haply Inverse Service at {} is version {}.{}; {}", to_string(service_), version->major, version->minor, why);
  }
  return {};
}

Result<void> HaplyDevice::open() {
  const bool is_first = model_.empty();
  // Read at each connection: a service that comes back may be of another version.
  const Result<std::string> version = read_http(service_, "/version", kConnectPatienceNs);
  auto socket = WebSocketEndpoint::connect(service_, kConnectPatienceNs);
  if (!socket) return fail("the Haply Inverse Service does not reply at {}; {}", socket.error().what, kRemedy);
  if (const auto checked = check_version(version); !checked) return checked;
  if (!(*socket)->receive(message_, kConnectPatienceNs)) {
    return fail("the Haply Inverse Service at {} sends no data: {}; {}", to_string(service_), (*socket)->reason(), kRemedy);
  }
  const auto inventory = haply::read_state(message_);
  if (!inventory) return tl::unexpected(inventory.error());
  const auto arm =
      std::find_if(inventory->arms.begin(), inventory->arms.end(), [&](const haply::Arm& each) { return id_.empty() || each.id == id_; });
  if (arm == inventory->arms.end()) {
    return fail("the Haply Inverse Service finds {}; check its cable and power, and the Haply Hub",
                inventory->arms.empty() ? "no Inverse3" : "no Inverse3 with that --device-id");
  }
  if (is_first) {
    id_ = arm->id;
    model_ = arm->model.empty() ? "inverse3" : arm->model;
    firmware_ = arm->firmware;
  }
  if (!(*socket)->send(haply::first_message(id_), kReplyPatienceNs)) return fail("{}: {}", to_string(service_), (*socket)->reason());
  socket_ = std::move(*socket);
  session_ = {};
  session_.update(*arm);
  absences_ = 0;
  return {};
}

void HaplyDevice::publish(DeviceStatus status, std::int64_t now_ns) {
  reading_.status = status;
  reading_.sample.time_ns = now_ns;
  exchange_.publish(reading_);
}

void HaplyDevice::run() {
  // An error is ignored: what is denied here is also denied to the servo's thread, which logs it.
  if (realtime_) (void)enter_realtime(*realtime_);
  std::int64_t tick_ns = clock_.now_ns();
  while (!ends_.load(std::memory_order_relaxed)) {
    tick_ns = std::max(tick_ns + kCommandPeriodNs, clock_.now_ns());
    clock_.sleep_until_ns(tick_ns);
    if (socket_ == nullptr) {
      look_for_service(tick_ns);
    } else if (!tick()) {
      log_warning("the Haply Inverse Service is disconnected ({}); trying to reconnect", socket_->reason());
      socket_.reset();
      next_try_ns_ = clock_.now_ns() + kRetryEveryNs / 4;  // until then the servo has seen that the device was away
      publish(DeviceStatus::away, clock_.now_ns());
    }
  }
  if (socket_ == nullptr) return;
  // Sends zero force as the last message and waits for the reply, since data in transit may be lost when a connection closes.
  if (socket_->receive(message_, kReplyPatienceNs) && socket_->send(haply::force_message(id_, Vec3::Zero()), kReplyPatienceNs)) {
    socket_->receive(message_, kReplyPatienceNs);
  }
  socket_->close(kReplyPatienceNs);
}

void HaplyDevice::look_for_service(std::int64_t now_ns) {
  publish(DeviceStatus::away, now_ns);
  if (now_ns < next_try_ns_) return;
  next_try_ns_ = now_ns + kRetryEveryNs;
  if (const auto opened = open(); !opened) {
    // Logs each reason once, not every second.
    if (std::exchange(logged_reason_, opened.error().what) != opened.error().what) log_info("searching: {}", logged_reason_);
    return;
  }
  logged_reason_.clear();
  log_info("reconnected to the Haply Inverse Service, device {}", id_);
}

// Receives the reply to the last message, then sends the next. False: the connection is closed.
bool HaplyDevice::tick() {
  if (!socket_->receive(message_, kReplyPatienceNs)) return false;
  const std::int64_t now_ns = clock_.now_ns();
  // A state that cannot be read is ignored.
  if (const auto state = haply::read_state(message_)) take(*state, now_ns);
  return socket_->send(haply::force_message(id_, session_.force_from_w(exchange_.wrench(now_ns).force_n)), kReplyPatienceNs);
}

void HaplyDevice::take(const haply::State& state, std::int64_t now_ns) {
  const auto arm = std::find_if(state.arms.begin(), state.arms.end(), [&](const haply::Arm& each) { return each.id == id_; });
  if (arm == state.arms.end()) {
    if (++absences_ == kMaxAbsences) log_warning("{} {} is disconnected; trying to reconnect", model_, id_);
    if (absences_ >= kMaxAbsences) publish(DeviceStatus::away, now_ns);
    return;
  }
  if (std::exchange(absences_, 0) >= kMaxAbsences) log_info("{} {} is back", model_, id_);
  session_.update(*arm);
  if (session_.is_scaled()) {
    if (!std::exchange(is_scale_logged_, true)) {
      log_warning("{} {}: the session's mount or transform has a scale, which would change how stiff things are: no force until it is 1",
                  model_, id_);
    }
    return publish(DeviceStatus::away, now_ns);
  }
  is_scale_logged_ = false;
  reading_.sample.p_WD = session_.to_w(arm->position_m);
  reading_.is_calibrated = arm->is_calibrated;
  if (state.grip) {
    reading_.sample.q_WT = state.grip->q_WT;
    reading_.sample.buttons = state.grip->buttons;
  } else {
    reading_.sample.buttons = 0;  // without a grip, nobody holds the dead man's switch
  }
  if (!arm->is_calibrated && !std::exchange(is_calibration_logged_, true)) {
    log_warning("{} {}: calibrate: leave the arm on its rest, or put the grip into the inkwell, until its light stays on", model_, id_);
  }
  publish(arm->is_calibrated ? DeviceStatus::ready : DeviceStatus::calibrating, now_ns);
}

}  // namespace

Result<std::unique_ptr<Device>> make_haply(const DeviceSettings& settings) {
  const std::size_t at = settings.id.find('@');
  const std::string id = settings.id.substr(0, at);
  const auto service = parse_address(at == std::string::npos ? kService : std::string_view(settings.id).substr(at + 1), kPort);
  if (!service) return tl::unexpected(service.error());
  auto device = std::make_unique<HaplyDevice>(*service, id, settings.realtime);
  if (const auto opened = device->open(); !opened) return tl::unexpected(opened.error());
  log_info("Haply Inverse Service: {} {}, at most {:.2f} N", device->condition().model, device->condition().serial,
           device->limits().max_force_n);
  device->start();
  return device;
}

}  // namespace hapton
