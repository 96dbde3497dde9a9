#include "tests/hid_guest/uhid_device.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/uhid.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "runtime/clock.h"

namespace hapton::guest {
namespace {

constexpr std::uint16_t kBusUsb = 3;

std::uint32_t now_us() { return static_cast<std::uint32_t>(SteadyClock().now_ns() / 1000); }

bool write_event(int descriptor, const uhid_event& event) { return ::write(descriptor, &event, sizeof event) == sizeof event; }

void put_text(__u8* into, std::size_t capacity, const std::string& text) {
  std::memcpy(into, text.data(), std::min(text.size(), capacity - 1));
}

}  // namespace

void UhidDevice::plug_in() {
  descriptor_ = ::open("/dev/uhid", O_RDWR | O_CLOEXEC);
  ASSERT_GE(descriptor_, 0) << "/dev/uhid: " << std::strerror(errno);
  uhid_event event = {};
  event.type = UHID_CREATE2;
  put_text(event.u.create2.name, sizeof event.u.create2.name, identity_.name);
  put_text(event.u.create2.uniq, sizeof event.u.create2.uniq, identity_.serial);
  event.u.create2.bus = kBusUsb;
  event.u.create2.vendor = identity_.vid;
  event.u.create2.product = identity_.pid;
  event.u.create2.rd_size = static_cast<__u16>(identity_.descriptor.size());
  std::copy(identity_.descriptor.begin(), identity_.descriptor.end(), event.u.create2.rd_data);
  ASSERT_TRUE(write_event(descriptor_, event)) << "the kernel rejects the device: " << std::strerror(errno);
  ends_ = false;
  thread_ = std::thread([this] { run(); });
}

void UhidDevice::unplug() {
  if (!thread_.joinable()) return;
  ends_ = true;
  thread_.join();
  uhid_event event = {};
  event.type = UHID_DESTROY;
  EXPECT_TRUE(write_event(descriptor_, event));
  ::close(descriptor_);
  descriptor_ = -1;
}

void UhidDevice::run() {
  SteadyClock clock;
  std::int64_t next_ns = clock.now_ns();
  while (!ends_) {
    for (const Bytes& report : make_inputs(now_us())) {
      uhid_event event = {};
      event.type = UHID_INPUT2;
      event.u.input2.size = static_cast<__u16>(report.size());
      std::copy(report.begin(), report.end(), event.u.input2.data);
      inputs_ += write_event(descriptor_, event) ? 1 : 0;
    }
    next_ns = std::max(next_ns + kNanosecondsPerMillisecond, clock.now_ns());
    while (clock.now_ns() < next_ns) receive(1);
  }
}

void UhidDevice::receive(int wait_ms) {
  pollfd waited{descriptor_, POLLIN, 0};
  if (::poll(&waited, 1, wait_ms) <= 0) return;
  uhid_event event = {};
  if (::read(descriptor_, &event, sizeof event) <= 0) return;
  if (event.type == UHID_OUTPUT) {
    ++outputs_;
    take_output(Bytes(event.u.output.data, event.u.output.data + std::min<std::size_t>(event.u.output.size, UHID_DATA_MAX)), now_us());
  } else if (event.type == UHID_GET_REPORT) {
    const Bytes feature = make_feature(event.u.get_report.rnum);
    uhid_event reply = {};
    reply.type = UHID_GET_REPORT_REPLY;
    reply.u.get_report_reply.id = event.u.get_report.id;
    reply.u.get_report_reply.err = feature.empty() ? EIO : 0;
    reply.u.get_report_reply.size = static_cast<__u16>(feature.size());
    std::copy(feature.begin(), feature.end(), reply.u.get_report_reply.data);
    EXPECT_TRUE(write_event(descriptor_, reply));
  }
}

}  // namespace hapton::guest
