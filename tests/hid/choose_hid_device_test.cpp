#include "hid/choose_hid_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace hapton {
namespace {

using ::testing::HasSubstr;

HidDescription device(std::string path, std::uint16_t vid, std::uint16_t pid, std::string serial = "") {
  HidDescription description;
  description.path = std::move(path);
  description.vid = vid;
  description.pid = pid;
  description.serial = std::move(serial);
  return description;
}

HidDescription wooden(std::string path, std::string serial = "") { return device(std::move(path), 0x1234, 0x0006, std::move(serial)); }

std::string rejection(const Result<HidDescription>& chosen) { return chosen ? "chose " + chosen->path : chosen.error().what; }

TEST(ChooseHidDevice, TheOnlyOneOfItsKindNeedsNoName) {
  const std::vector devices = {device("/dev/hidraw0", 0x046d, 0xc077), wooden("/dev/hidraw1", "A")};
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "")->path, "/dev/hidraw1");
}

TEST(ChooseHidDevice, SaysWhatToDoWhereNoneIsThere) {
  const std::vector devices = {device("/dev/hidraw0", 0x046d, 0xc077)};
  for (const auto& [kind, line] :
       {std::pair(HidKind::wooden_haptics, "no WoodenHaptics is plugged in, among 1 HID devices; plug it in, switch"),
        std::pair(HidKind::hapton_hid, "no Hapton HID is plugged in, among 1 HID devices; plug one in (docs/hid.md"),
        std::pair(HidKind::space_mouse, "no SpaceMouse is plugged in, among 1 HID devices; plug it or its receiver"),
        std::pair(HidKind::vendor_driver, "no vendor's driver is plugged in, among 1 HID devices; plug it in, or")}) {
    EXPECT_THAT(rejection(choose_hid_device(devices, kind, "")), HasSubstr(line));
  }
}

TEST(ChooseHidDevice, SeveralAreDistinguishedBySerialNumberPathOrPlace) {
  const std::vector devices = {wooden("/dev/hidraw1", "A"), wooden("/dev/hidraw4", "B")};
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "B")->path, "/dev/hidraw4");
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "/dev/hidraw1")->path, "/dev/hidraw1");
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "1")->path, "/dev/hidraw4");
  const std::string line = rejection(choose_hid_device(devices, HidKind::wooden_haptics, ""));
  EXPECT_THAT(line, HasSubstr("say which"));
  EXPECT_THAT(line, HasSubstr("/dev/hidraw1 (A), /dev/hidraw4 (B)"));
}

// A place is a count from 0 with one or two digits; longer numbers are serial numbers.
TEST(ChooseHidDevice, APlaceIsANumberBelowTheirCount) {
  const std::vector devices = {wooden("/dev/hidraw1", "007"), wooden("/dev/hidraw4", "B")};
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "0")->path, "/dev/hidraw1");
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "01")->path, "/dev/hidraw4");
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "007")->path, "/dev/hidraw1") << "a serial number";
  for (const char* none : {"2", "001", "-1", "1x", "99"}) EXPECT_FALSE(choose_hid_device(devices, HidKind::wooden_haptics, none)) << none;
}

// A device with several interfaces may be listed once for each.
TEST(ChooseHidDevice, OnePathIsOneDevice) {
  const std::vector devices = {wooden("/dev/hidraw1", "A"), wooden("/dev/hidraw1", "A")};
  EXPECT_EQ(choose_hid_device(devices, HidKind::wooden_haptics, "")->path, "/dev/hidraw1");
  EXPECT_FALSE(choose_hid_device(devices, HidKind::wooden_haptics, "1"));
}

TEST(ChooseHidDevice, EachKindHasItsHint) {
  const auto hint = [](HidKind kind) { return rejection(choose_hid_device({}, kind, "")); };
  EXPECT_THAT(hint(HidKind::wooden_haptics),
              HasSubstr("no WoodenHaptics is plugged in, among 0 HID devices; plug it in, switch its motor"));
  EXPECT_THAT(hint(HidKind::hapton_hid), HasSubstr("docs/hid.md"));
  EXPECT_THAT(hint(HidKind::space_mouse), HasSubstr("plug it or its receiver in"));
  const std::vector nameless = {wooden("/dev/hidraw1"), wooden("/dev/hidraw2", "B")};
  EXPECT_THAT(rejection(choose_hid_device(nameless, HidKind::wooden_haptics, "")),
              HasSubstr("2 WoodenHaptics devices are plugged in; say which by serial number or path: /dev/hidraw1 (no serial number), "));
}

TEST(ChooseHidDevice, AnUnknownNameListsTheKnownOnes) {
  const std::vector devices = {wooden("/dev/hidraw1", "A")};
  EXPECT_THAT(rejection(choose_hid_device(devices, HidKind::wooden_haptics, "C")), HasSubstr("'C'; plugged in are: /dev/hidraw1 (A)"));
  EXPECT_THAT(rejection(choose_hid_device(devices, HidKind::wooden_haptics, "1")), HasSubstr("'1'"));
}

TEST(ChooseHidDevice, NoneOfItsKindSaysHowManyOthersThereAre) {
  const std::vector devices = {device("/dev/hidraw0", 0x046d, 0xc077)};
  EXPECT_THAT(rejection(choose_hid_device(devices, HidKind::hapton_hid, "")),
              HasSubstr("no Hapton HID is plugged in, among 1 HID devices"));
}

TEST(ChooseHidDevice, AHaptonHidDeviceIsFoundByAnyOfItsUsages) {
  HidDescription composite = device("/dev/hidraw2", 0xcafe, 1);
  composite.usage_page = 1;
  composite.usage = 6;
  EXPECT_FALSE(choose_hid_device(std::vector{composite}, HidKind::hapton_hid, ""));
  composite.layout.applications = {{1, 6}, {kHaptonHidUsagePage, kHaptonHidUsage}};
  EXPECT_TRUE(choose_hid_device(std::vector{composite}, HidKind::hapton_hid, ""));
}

TEST(ChooseHidDevice, TheSameDeviceMayComeBackAtAnotherNode) {
  EXPECT_TRUE(is_same_device(wooden("/dev/hidraw1", "A"), wooden("/dev/hidraw7", "A")));
  EXPECT_FALSE(is_same_device(wooden("/dev/hidraw1", "A"), wooden("/dev/hidraw1", "B")));
  EXPECT_FALSE(is_same_device(device("/dev/hidraw1", 1, 2, "A"), device("/dev/hidraw1", 1, 3, "A")));
  EXPECT_FALSE(is_same_device(device("/dev/hidraw1", 1, 2, "A"), device("/dev/hidraw1", 4, 2, "A")));
}

// A device was unplugged. Two without serial numbers look the same, and the wrong one must not exert the force of the other.
TEST(ChooseHidDevice, IsFoundAgainWhereverItIsUnlessAnotherLooksTheSame) {
  const auto find_again = [](const std::vector<HidDescription>& devices, const HidDescription& chosen, bool had_twin = false) {
    const auto found = find_hid_device_again(devices, chosen, HidKind::wooden_haptics, had_twin);
    return found ? found->path : found.error().what;
  };
  const HidDescription mouse = device("/dev/hidraw0", 0x046d, 0xc077);
  EXPECT_EQ(find_again({mouse, wooden("/dev/hidraw7", "A")}, wooden("/dev/hidraw1", "A")), "/dev/hidraw7");
  EXPECT_EQ(find_again({wooden("/dev/hidraw1", "B"), wooden("/dev/hidraw7", "A")}, wooden("/dev/hidraw1", "A")), "/dev/hidraw7");
  EXPECT_THAT(find_again({mouse, wooden("/dev/hidraw1", "B")}, wooden("/dev/hidraw1", "A")),
              HasSubstr("the WoodenHaptics used before (A) is not among"));
  const std::vector twins = {wooden("/dev/hidraw1"), wooden("/dev/hidraw4")};
  EXPECT_EQ(find_again(twins, wooden("/dev/hidraw4")), "/dev/hidraw4");
  EXPECT_EQ(find_again(twins, wooden("/dev/hidraw1")), "/dev/hidraw1");
  EXPECT_THAT(find_again(twins, wooden("/dev/hidraw5")), HasSubstr("/dev/hidraw5")) << "either may be the one";
  EXPECT_TRUE(has_twin(twins, twins[0]));
  EXPECT_FALSE(has_twin(std::vector{mouse, twins[0]}, twins[0]));
  EXPECT_THAT(find_again({mouse, twins[0]}, twins[1], true), HasSubstr("/dev/hidraw4")) << "only the device of the other hand is left";
  EXPECT_EQ(find_again({mouse, twins[1]}, twins[1], true), "/dev/hidraw4");
}

// Earlier this line did not count the other devices: it said "among 0 HID devices".
TEST(ChooseHidDevice, AMissingDeviceIsReportedWithTheNumberOfOthers) {
  const std::vector others = {device("/dev/hidraw0", 0x046d, 0xc077), wooden("/dev/hidraw1", "B")};
  EXPECT_EQ(rejection(find_hid_device_again(others, wooden("/dev/hidraw1", "A"), HidKind::wooden_haptics, false)),
            "the WoodenHaptics used before (A) is not among the 2 HID devices that are plugged in; plug it in again");
  EXPECT_THAT(rejection(find_hid_device_again(others, wooden("/dev/hidraw1"), HidKind::wooden_haptics, false)),
              HasSubstr("the WoodenHaptics used before (no serial number)"));
}

TEST(ChooseHidDevice, OnceOneWasOpenedOnlyThatOneIsOpenedAgain) {
  HidChoice choice(HidKind::wooden_haptics, "1");
  const std::vector both = {wooden("/dev/hidraw1", "A"), wooden("/dev/hidraw4", "B")};
  ASSERT_EQ(choice.choose(both)->path, "/dev/hidraw4");
  // It was chosen but could not be opened, so the next choice goes by its place again.
  EXPECT_EQ(choice.choose(std::vector{both[1], both[0]})->path, "/dev/hidraw1");
  choice.note_opened(both[1], both);
  EXPECT_EQ(choice.choose(std::vector{both[1], both[0]})->path, "/dev/hidraw4");
  EXPECT_FALSE(choice.choose(std::vector{both[0]}));
  EXPECT_EQ(choice.choose(std::vector{both[0], wooden("/dev/hidraw9", "B")})->path, "/dev/hidraw9");
}

// The other device is still plugged in, and would exert the force on the wrong hand.
TEST(ChooseHidDevice, ATwinThatWasThereOnceIsRemembered) {
  const std::vector twins = {wooden("/dev/hidraw1"), wooden("/dev/hidraw4")};
  HidChoice choice(HidKind::wooden_haptics, "/dev/hidraw4");
  choice.note_opened(twins[1], twins);
  EXPECT_FALSE(choice.choose(std::vector{twins[0]}));
  choice.note_opened(twins[1], std::vector{twins[1]});
  EXPECT_FALSE(choice.choose(std::vector{twins[0]})) << "opened again while the other one was away";
  HidChoice alone(HidKind::wooden_haptics, "");
  alone.note_opened(twins[1], std::vector{twins[1]});
  EXPECT_EQ(alone.choose(std::vector{twins[0]})->path, "/dev/hidraw1");
}

// The second device was plugged in while the first one was in use, and is the only one left when the first one is unplugged.
TEST(ChooseHidDevice, ATwinThatWasPluggedInLaterIsNotTakenForTheOneThatIsGone) {
  const std::vector twins = {wooden("/dev/hidraw1"), wooden("/dev/hidraw4")};
  HidChoice choice(HidKind::wooden_haptics, "");
  choice.note_gone(twins);  // no device was opened yet
  choice.note_opened(twins[0], std::vector{twins[0]});
  choice.note_gone(std::vector{device("/dev/hidraw0", 0x046d, 0xc077), twins[1]});
  EXPECT_EQ(
      rejection(choice.choose(std::vector{twins[1]})),
      "the WoodenHaptics from before was /dev/hidraw1; a device that looks the same may be another one: /dev/hidraw4 (no serial number); "
      "start this program again to use it");
  EXPECT_EQ(choice.choose(twins)->path, "/dev/hidraw1");
  HidChoice alone(HidKind::wooden_haptics, "");
  alone.note_opened(twins[0], std::vector{twins[0]});
  alone.note_gone(std::vector{twins[0]});  // the system still lists it
  EXPECT_EQ(alone.choose(std::vector{twins[1]})->path, "/dev/hidraw4") << "it is back at another node";
}

// Each interface of a device has its own node, but all of them have the ids of the device.
TEST(ChooseHidDevice, AnotherInterfaceOfADeviceIsNoTwin) {
  HidDescription keys = wooden("/dev/hidraw1", "A");
  keys.usage_page = 1;
  keys.usage = 6;
  HidDescription arm = wooden("/dev/hidraw2", "A");
  arm.usage_page = 0xFF00;
  arm.usage = 1;
  HidChoice choice(HidKind::wooden_haptics, "/dev/hidraw2");
  choice.note_opened(arm, std::vector{keys, arm});
  keys.path = "/dev/hidraw3";
  arm.path = "/dev/hidraw4";
  EXPECT_EQ(choice.choose(std::vector{keys, arm})->path, "/dev/hidraw4");
}

TEST(ChooseHidDevice, PlacesAreInTheOrderOfTheNodesNumbers) {
  std::vector devices = {wooden("/dev/hidraw10"), wooden("/dev/hidraw9"), wooden("/dev/hidraw2")};
  std::sort(devices.begin(), devices.end(), is_listed_before);
  EXPECT_EQ(devices[0].path, "/dev/hidraw2");
  EXPECT_EQ(devices[1].path, "/dev/hidraw9");
  EXPECT_EQ(devices[2].path, "/dev/hidraw10");
}

}  // namespace
}  // namespace hapton
