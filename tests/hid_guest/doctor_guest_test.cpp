// hapton doctor in a QEMU guest: on the sysfs of a real kernel, with devices that are plugged in and unplugged.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/hid_guest/virtual_devices.h"
#include "tests/support/patience.h"
#include "tools/doctor/diagnosis.h"

namespace hapton::guest {
namespace {

std::string diagnose_devices() {
  const doctor::Machine machine("/", doctor::Machine::Queries{}, doctor::Machine::Settings{});
  constexpr bool kWithColours = false;
  return doctor::to_text(doctor::diagnose(machine, std::vector<std::string>{"devices"}), kWithColours);
}

bool wait_for_text(const std::string& text) {
  return wait_until([&] { return diagnose_devices().find(text) != std::string::npos; });
}

TEST(GuestDoctor, SeesDevicesComeAndGo) {
  EXPECT_TRUE(wait_for_text("none is plugged in")) << diagnose_devices();
  constexpr bool kHasWrist = false;
  VirtualWooden wooden(kHasWrist);  // its name is W8
  VirtualHaptonHid hapton_hid;
  VirtualSpaceMouse mouse;
  wooden.plug_in();
  hapton_hid.plug_in();
  mouse.plug_in();
  EXPECT_TRUE(wait_for_text("WoodenHaptics 1234:0006 W8: /dev/hidraw")) << diagnose_devices();
  EXPECT_TRUE(wait_for_text("(hid-generic), open to root; io_node --device wooden-haptics")) << diagnose_devices();
  EXPECT_TRUE(wait_for_text("Hapton HID device ")) << diagnose_devices();
  EXPECT_TRUE(wait_for_text("io_node --device hapton-hid")) << diagnose_devices();
  EXPECT_TRUE(wait_for_text("io_node --device spacemouse")) << diagnose_devices();
  wooden.unplug();
  EXPECT_TRUE(wait_until([] { return diagnose_devices().find("WoodenHaptics") == std::string::npos; })) << diagnose_devices();
}

}  // namespace
}  // namespace hapton::guest
