#include "hid/hidapi_transport.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// Which devices this machine has is not known; the guest of deploy/hid-test has devices. These tests check that the calls return, and that
// each error is one line.
TEST(HidapiTransport, EachListedDeviceHasANodeInDev) {
  const std::vector<HidDescription> devices = list_hid_devices();
  if (devices.empty()) GTEST_SKIP() << "this machine has no HID devices";
  for (const HidDescription& device : devices) EXPECT_EQ(device.path.rfind("/dev/", 0), 0U) << device.path;
}

TEST(HidapiTransport, ReadsTheDescriptorOfTheNodesOwnName) {
  const ScratchFolder classes;
  for (const char* node : {"hidraw1", "hidraw10"}) std::filesystem::create_directories(classes.path() / node / "device");
  classes.write("hidraw1/device/report_descriptor", std::string("\x75\x08\x95\x02\x81\x02", 6));
  classes.write("hidraw10/device/report_descriptor", std::string("\x75\x08\x95\x03\x81\x02", 6));
  const auto bytes_of = [&](const char* path) {
    const HidLayout layout = read_hidraw_layout(path, classes.path());
    return layout.reports.empty() ? 0U : layout.reports.front().input_bytes;
  };
  EXPECT_EQ(bytes_of("/dev/hidraw1"), 2U);
  EXPECT_EQ(bytes_of("/dev/hidraw10"), 3U);
  EXPECT_EQ(bytes_of("hidraw10"), 3U);
  EXPECT_EQ(bytes_of("/dev/hidraw2"), 0U) << "it may be unplugged by now";
}

// Otherwise each signal would be taken for an unplugged device, and the force would be released.
TEST(HidapiTransport, ASignalDuringAReadDoesNotCountAsUnplugged) {
  const auto outcome = [](int returned, int error) { return to_hid_read(returned, error).outcome; };
  EXPECT_EQ(outcome(-1, EINTR), HidIo::nothing);
  EXPECT_EQ(outcome(-1, ENODEV), HidIo::gone);
  EXPECT_EQ(outcome(-1, 0), HidIo::gone);
  EXPECT_EQ(outcome(0, EINTR), HidIo::nothing);
  EXPECT_EQ(outcome(1, EINTR), HidIo::done);
  EXPECT_EQ(to_hid_read(-1, EINTR).size, 0U);
  EXPECT_EQ(to_hid_read(-1, ENODEV).size, 0U);
  EXPECT_EQ(to_hid_read(7, 0).size, 7U);
}

TEST(HidapiTransport, ANodeThatIsNotThereIsAnErrorInOneLineAtOnce) {
  HidDescription device;
  device.path = "/dev/hapton-has-no-such-node";
  const auto opened = open_hid_device(device);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().what.rfind("/dev/hapton-has-no-such-node: it cannot be opened: ", 0), 0U) << opened.error().what;
  EXPECT_EQ(opened.error().what.find('\n'), std::string::npos);
}

// The file may be read and written, but is not a device: waiting would not change that.
TEST(HidapiTransport, AFileThatIsNoDeviceIsNotDenied) {
  const ScratchFolder folder;
  HidDescription device;
  device.path = folder.write("file", "no device").string();
  const std::string expected = device.path + ": it cannot be opened: it is not a HID device, or was just unplugged";
  const auto opened = open_hid_device(device);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().what, expected);
  // A program without a standard input opens the file as descriptor 0.
  const int input = ::dup(STDIN_FILENO);
  ::close(STDIN_FILENO);
  const auto opened_as_zero = open_hid_device(device);
  const bool is_closed = ::fcntl(STDIN_FILENO, F_GETFD) < 0;
  if (input >= 0) {
    ::dup2(input, STDIN_FILENO);
    ::close(input);
  }
  ASSERT_FALSE(opened_as_zero);
  EXPECT_EQ(opened_as_zero.error().what, expected);
  EXPECT_TRUE(is_closed);
}

// udev grants access a moment after a device appears. Opening waits for that for a second, and then reports that the rules are missing.
TEST(HidapiTransport, ADeniedNodeIsTriedForASecondAndThenNamesTheRules) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto open_as_nobody = [] {
    const ScratchFolder folder;
    HidDescription device;
    device.path = folder.write("denied", "nobody may").string();
    std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
    std::filesystem::permissions(device.path, std::filesystem::perms::none);
    constexpr uid_t kNobody = 65534;
    if (::geteuid() == 0 && ::seteuid(kNobody) != 0) std::_Exit(2);
    const std::int64_t begin_ns = SteadyClock().now_ns();
    const auto opened = open_hid_device(device);
    const std::int64_t took_ns = SteadyClock().now_ns() - begin_ns;
    if (opened || took_ns < kNanosecondsPerSecond) std::_Exit(1);
    std::fprintf(stderr, "%s\n", opened.error().what.c_str());
    if (::getuid() == 0 && ::seteuid(0) != 0) std::_Exit(2);
    std::filesystem::remove_all(folder.path());
    std::_Exit(0);
  };
  EXPECT_EXIT(open_as_nobody(), testing::ExitedWithCode(0), "denied: permission denied; install the udev rules");
}

TEST(HidapiTransport, AnOpenerForAnUnknownIdReportsIt) {
  const auto opened = make_hid_opener(HidKind::hapton_hid, "no device of this world")();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("Hapton HID"), std::string::npos) << opened.error().what;
}

}  // namespace
}  // namespace hapton
