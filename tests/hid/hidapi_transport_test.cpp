#include "hid/hidapi_transport.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// The devices of this machine are unknown; the guest of deploy/hid-test has devices. Here: that it replies, and that errors are one
// line.
TEST(HidapiTransport, ListsWhatThereIsWithoutPermissions) {
  for (const HidDescription& device : list_hid_devices()) EXPECT_EQ(device.path.rfind("/dev/", 0), 0U);
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

// Else each signal would count as unplugged, and the force would be released.
TEST(HidapiTransport, ASignalDuringAReadIsNoUnplugging) {
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
  EXPECT_NE(opened.error().what.find("/dev/hapton-has-no-such-node"), std::string::npos) << opened.error().what;
  EXPECT_EQ(opened.error().what.find('\n'), std::string::npos);
}

TEST(HidapiTransport, AnOpenerForAnUnknownIdReportsIt) {
  const auto opened = make_hid_opener(HidKind::hapton_hid, "no device of this world")();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("Hapton HID"), std::string::npos) << opened.error().what;
}

}  // namespace
}  // namespace hapton
