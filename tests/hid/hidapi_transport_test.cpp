#include "hid/hidapi_transport.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// The devices of this machine are unknown; the guest of deploy/hid-test has devices. Here: that it replies, and that errors are one
// line.
TEST(HidapiTransport, ListsWhatThereIsWithoutPermissions) {
  for (const HidDescription& device : list_hid_devices()) EXPECT_EQ(device.path.rfind("/dev/", 0), 0U);
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
