#include "hid/hidapi_transport.h"

#include <fcntl.h>
#include <hidapi.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <mutex>

#include "hid/choose_hid_device.h"
#include "hid/device_lock.h"
#include "hid/utf8.h"
#include "runtime/clock.h"

namespace hapton {
namespace {

// Locked by the one thread that uses the global state of hidapi: the list of devices, opening, and the last error.
std::mutex hidapi_turn;

constexpr std::int64_t kAccessPatienceNs = kNanosecondsPerSecond;
constexpr std::int64_t kAccessEveryNs = 20 * kNanosecondsPerMillisecond;  // between two attempts, until udev has granted access

HidDescription describe(const hid_device_info& info) {
  HidDescription device;
  device.path = info.path;
  device.vid = info.vendor_id;
  device.pid = info.product_id;
  device.usage_page = info.usage_page;
  device.usage = info.usage;
  device.serial = to_utf8(info.serial_number);
  device.maker = to_utf8(info.manufacturer_string);
  device.product = to_utf8(info.product_string);
  device.layout = read_hidraw_layout(device.path);
  return device;
}

struct CloseHid {
  void operator()(hid_device* device) const noexcept { hid_close(device); }
};
using HidHandle = std::unique_ptr<hid_device, CloseHid>;

// Two handles, because a hidapi handle is for one thread. Each has a queue of its own in the kernel; that of `writing_` is never read.
class HidapiTransport final : public HidTransport {
 public:
  HidapiTransport(HidDescription description, DeviceLock lock, HidHandle reading, HidHandle writing, std::function<void()> on_gone)
      : description_(std::move(description)),
        lock_(std::move(lock)),
        reading_(std::move(reading)),
        writing_(std::move(writing)),
        on_gone_(std::move(on_gone)) {}

  const HidDescription& description() const noexcept override { return description_; }

  HidRead read(std::span<std::uint8_t> into, int wait_ms) noexcept override {
    errno = 0;
    const int size = hid_read_timeout(reading_.get(), into.data(), into.size(), wait_ms);
    const HidRead read = to_hid_read(size, errno);
    is_gone_ = is_gone_ || read.outcome == HidIo::gone;
    return read;
  }

  void note_gone() override {
    if (is_gone_ && on_gone_) on_gone_();
  }

  bool write(std::span<const std::uint8_t> report) noexcept override {
    return hid_write(writing_.get(), report.data(), report.size()) >= 0;
  }

  Result<std::size_t> get_feature(std::span<std::uint8_t> into) override {
    const int id = into.empty() ? -1 : into.front();
    const int read = hid_get_feature_report(writing_.get(), into.data(), into.size());
    if (read < 0) return fail("{}: it does not give feature report {}: {}", description_.path, id, to_utf8(hid_error(writing_.get())));
    return static_cast<std::size_t>(read);
  }

 private:
  HidDescription description_;
  DeviceLock lock_;
  HidHandle reading_;
  HidHandle writing_;
  std::function<void()> on_gone_;
  bool is_gone_ = false;  // used by the reading thread only
};

bool is_refused(const std::string& path) {
  return ::faccessat(AT_FDCWD, path.c_str(), R_OK | W_OK, AT_EACCESS) != 0 && (errno == EACCES || errno == EPERM);
}

// hidapi 0.13 uses freed memory if a node that it opens is not a hidraw node, or has just been unplugged. True also for a node that cannot
// be opened: hidapi then says why.
bool may_be_hidraw(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return true;
  int size = 0;
  const bool has_descriptor = ::ioctl(file, HIDIOCGRDESCSIZE, &size) >= 0;
  ::close(file);
  return has_descriptor;
}

Result<HidHandle> open_handle(const std::string& path) {
  SteadyClock clock;
  const std::int64_t until_ns = clock.now_ns() + kAccessPatienceNs;
  while (true) {
    {
      if (!may_be_hidraw(path)) return fail("{}: it cannot be opened: it is not a HID device, or was just unplugged", path);
      const std::lock_guard turn(hidapi_turn);
      HidHandle handle(hid_open_path(path.c_str()));
      if (handle) return handle;
      if (!is_refused(path)) return fail("{}: it cannot be opened: {}", path, to_utf8(hid_error(nullptr)));
    }
    if (clock.now_ns() >= until_ns) {
      return fail("{}: permission denied; install the udev rules (deploy/udev/70-hapton.rules, or the Debian package) and plug it in again",
                  path);
    }
    clock.sleep_until_ns(clock.now_ns() + kAccessEveryNs);
  }
}

}  // namespace

HidLayout read_hidraw_layout(const std::string& path, const std::filesystem::path& classes) {
  std::ifstream file(classes / std::filesystem::path(path).filename() / "device/report_descriptor", std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::vector<std::uint8_t> descriptor(bytes.begin(), bytes.end());
  return read_hid_layout(descriptor);
}

HidRead to_hid_read(int returned, int error) noexcept {
  if (returned > 0) return {HidIo::done, static_cast<std::size_t>(returned)};
  return {returned == 0 || error == EINTR ? HidIo::nothing : HidIo::gone, 0};
}

std::vector<HidDescription> list_hid_devices() {
  std::vector<HidDescription> devices;
  const std::lock_guard turn(hidapi_turn);
  const std::unique_ptr<hid_device_info, decltype(&hid_free_enumeration)> all(hid_enumerate(0, 0), &hid_free_enumeration);
  for (const hid_device_info* info = all.get(); info != nullptr; info = info->next) {
    if (info->path == nullptr) continue;
    const bool is_listed =
        std::any_of(devices.begin(), devices.end(), [&](const HidDescription& known) { return known.path == info->path; });
    if (!is_listed) devices.push_back(describe(*info));
  }
  std::sort(devices.begin(), devices.end(), is_listed_before);
  return devices;
}

Result<std::unique_ptr<HidTransport>> open_hid_device(const HidDescription& device, HidSharing sharing, std::function<void()> on_gone) {
  auto reading = open_handle(device.path);
  if (!reading) return tl::unexpected(reading.error());
  auto lock = sharing == HidSharing::exclusive ? DeviceLock::take(device.path) : DeviceLock();
  if (!lock) return tl::unexpected(lock.error());
  auto writing = open_handle(device.path);
  if (!writing) return tl::unexpected(writing.error());
  return std::make_unique<HidapiTransport>(device, std::move(*lock), std::move(*reading), std::move(*writing), std::move(on_gone));
}

HidOpener make_hid_opener(HidKind kind, std::string id) {
  return [kind, choice = std::make_shared<HidChoice>(kind, std::move(id))]() -> Result<std::unique_ptr<HidTransport>> {
    const std::vector<HidDescription> devices = list_hid_devices();
    const auto device = choice->choose(devices);
    if (!device) return tl::unexpected(device.error());
    auto opened = open_hid_device(*device, kind == HidKind::space_mouse ? HidSharing::shared : HidSharing::exclusive,
                                  [choice] { choice->note_gone(list_hid_devices()); });
    if (opened) choice->note_opened(*device, devices);
    return opened;
  };
}

}  // namespace hapton
