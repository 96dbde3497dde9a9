// hapton doctor in a QEMU guest: on the sysfs of a real kernel, with devices that are plugged in and unplugged.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/hid_guest/virtual_devices.h"
#include "tests/support/patience.h"
#include "tools/doctor/diagnosis.h"

namespace hapton::guest {
namespace {

std::string look() {
  const doctor::Machine machine("/", doctor::Machine::Queries{}, doctor::Machine::Settings{});
  constexpr bool kWithColours = false;
  return doctor::to_text(doctor::diagnose(machine, std::vector<std::string>{"devices"}), kWithColours);
}

bool says(const std::string& text) {
  return wait_until([&] { return look().find(text) != std::string::npos; });
}

TEST(GuestDoctor, SeesDevicesComeAndGo) {
  EXPECT_TRUE(says("none is plugged in")) << look();
  constexpr bool kHasWrist = false;
  VirtualWooden wooden(kHasWrist);  // its name is W8
  VirtualHaptonHid hapton_hid;
  VirtualSpaceMouse mouse;
  wooden.plug_in();
  hapton_hid.plug_in();
  mouse.plug_in();
  EXPECT_TRUE(says("WoodenHaptics 1234:0006 W8: /dev/hidraw")) << look();
  EXPECT_TRUE(says("(hid-generic), open to root; io_node --device wooden-haptics")) << look();
  EXPECT_TRUE(says("Hapton HID device ")) << look();
  EXPECT_TRUE(says("io_node --device hapton-hid")) << look();
  EXPECT_TRUE(says("io_node --device spacemouse")) << look();
  wooden.unplug();
  EXPECT_TRUE(wait_until([] { return look().find("WoodenHaptics") == std::string::npos; })) << look();
}

}  // namespace
}  // namespace hapton::guest
