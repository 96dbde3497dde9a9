#include "hid/hid_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "docs/hid/hapton_hid_device.h"
#include "hid/hid_catalog.h"

namespace hapton {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<std::uint8_t>;

// The descriptor that the mbed library makes for WoodenHaptics: vendor page 0xFFAB, usage 0x0200, reports without numbers.
Bytes wooden_descriptor(std::uint8_t in, std::uint8_t out) {
  return {0x06, 0xAB, 0xFF, 0x0A, 0x00, 0x02, 0xA1, 0x01, 0x75, 0x08, 0x15, 0x00, 0x26, 0xFF,
          0x00, 0x95, in,   0x09, 0x01, 0x81, 0x02, 0x95, out,  0x09, 0x02, 0x91, 0x02, 0xC0};
}

TEST(HidLayout, DistinguishesTheVariantsOfWoodenHaptics) {
  const HidLayout layout = read_hid_layout(wooden_descriptor(8, 8));
  EXPECT_TRUE(layout.has_application(0xFFAB, 0x0200));
  EXPECT_THAT(layout.reports, ElementsAre(HidLayout::Report{0, 8, 8, 0}));
  EXPECT_THAT(read_hid_layout(wooden_descriptor(14, 14)).reports, ElementsAre(HidLayout::Report{0, 14, 14, 0}));
}

TEST(HidLayout, OfHaptonHidIsThatOfItsReports) {
  const HidLayout layout = read_hid_layout(hapton_hid_descriptor);
  EXPECT_THAT(layout.applications, ElementsAre(HidLayout::Usage{kHaptonHidUsagePage, kHaptonHidUsage}));
  EXPECT_THAT(layout.reports, ElementsAre(HidLayout::Report{HAPTON_HID_STATE_ID, HAPTON_HID_STATE_BYTES - 1, 0, 0},
                                          HidLayout::Report{HAPTON_HID_FORCE_ID, 0, HAPTON_HID_FORCE_BYTES - 1, 0},
                                          HidLayout::Report{HAPTON_HID_LIMITS_ID, 0, 0, HAPTON_HID_LIMITS_BYTES - 1},
                                          HidLayout::Report{HAPTON_HID_NAMES_ID, 0, 0, HAPTON_HID_NAMES_BYTES - 1}));
}

TEST(HidLayout, KnowsTheUsagesOfAllTopLevelCollections) {
  // A mouse (1/2) and a multi-axis controller (1/8) in one interface; the second one's usage has 4 bytes. Nested collections do not count.
  const Bytes descriptor = {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x01, 0xA1, 0x00,
                            0xC0, 0xC0, 0x0B, 0x08, 0x00, 0x01, 0x00, 0xA1, 0x01, 0xC0};
  EXPECT_THAT(read_hid_layout(descriptor).applications, ElementsAre(HidLayout::Usage{1, 2}, HidLayout::Usage{1, 8}));
}

// A collection may be given several usages; the first one is its own. A collection that is only physical is not an application.
TEST(HidLayout, AnApplicationHasTheFirstUsageAndAPhysicalCollectionNone) {
  EXPECT_THAT(read_hid_layout(Bytes{0x05, 0x01, 0x09, 0x08, 0x09, 0x02, 0xA1, 0x01, 0xC0}).applications,
              ElementsAre(HidLayout::Usage{1, 8}));
  EXPECT_TRUE(read_hid_layout(Bytes{0x05, 0x01, 0x09, 0x08, 0xA1, 0x00, 0xC0}).applications.empty());
}

TEST(HidLayout, PushAndPopRestoreTheSizes) {
  const Bytes descriptor = {0x75, 0x08, 0x95, 0x02, 0xA4, 0x75, 0x20, 0x95, 0x08, 0xB4, 0x81, 0x02};
  EXPECT_THAT(read_hid_layout(descriptor).reports, ElementsAre(HidLayout::Report{0, 2, 0, 0}));
}

const Bytes kMouse = {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0xC0};

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Bytes repeated(const Bytes& item, std::size_t times) {
  Bytes all;
  for (std::size_t n = 0; n < times; ++n) all = std::move(all) + item;
  return all;
}

// A usage stated for a report, or inside a collection, does not apply to the next collection.
TEST(HidLayout, AUsageHoldsUntilTheNextMainItem) {
  for (const std::uint8_t report : Bytes{0x81, 0x91, 0xB1}) {
    EXPECT_TRUE(read_hid_layout(Bytes{0x05, 0x01, 0x09, 0x08, report, 0x02, 0xA1, 0x01, 0xC0}).applications.empty()) << int{report};
    EXPECT_THAT(read_hid_layout(Bytes{0x05, 0x01, 0x09, 0x08, report, 0x02, 0x09, 0x02, 0xA1, 0x01, 0xC0}).applications,
                ElementsAre(HidLayout::Usage{1, 2}))
        << int{report};
  }
  // Another collection follows, which has no usage, or one of its own.
  const Bytes first = {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x08, 0xC0};
  EXPECT_THAT(read_hid_layout(Bytes(first) + Bytes{0xA1, 0x01, 0xC0}).applications, ElementsAre(HidLayout::Usage{1, 2}));
  EXPECT_THAT(read_hid_layout(Bytes(first) + Bytes{0x09, 0x08, 0xA1, 0x01, 0xC0}).applications,
              ElementsAre(HidLayout::Usage{1, 2}, HidLayout::Usage{1, 8}));
  // A logical minimum (0x15) is not a main item.
  EXPECT_THAT(read_hid_layout(Bytes{0x05, 0x01, 0x09, 0x08, 0x15, 0x00, 0xA1, 0x01, 0xC0}).applications,
              ElementsAre(HidLayout::Usage{1, 8}));
}

// A usage of two bytes is only the usage; in one of four bytes the upper two are the page.
TEST(HidLayout, AUsageOfFourBytesHasItsPage) {
  EXPECT_THAT(read_hid_layout(Bytes{0x05, 0x01, 0x0A, 0xFF, 0xFF, 0xA1, 0x01, 0xC0}).applications,
              ElementsAre(HidLayout::Usage{1, 0xFFFF}));
  EXPECT_THAT(read_hid_layout(Bytes{0x05, 0x01, 0x0B, 0x00, 0x00, 0x01, 0x00, 0xA1, 0x01, 0xC0}).applications,
              ElementsAre(HidLayout::Usage{1, 0}));
  EXPECT_THAT(read_hid_layout(Bytes{0x05, 0x01, 0x0B, 0x34, 0x12, 0xCD, 0xAB, 0xA1, 0x01, 0xC0}).applications,
              ElementsAre(HidLayout::Usage{0xABCD, 0x1234}));
}

TEST(HidLayout, AReportHasWholeBytes) {
  for (const std::size_t bits : {0U, 1U, 7U, 8U, 9U, 16U, 17U}) {
    const Bytes descriptor = {0x75, static_cast<std::uint8_t>(bits), 0x95, 0x01, 0x81, 0x02, 0x95, 0x02, 0x91, 0x02, 0x95, 0x03, 0xB1,
                              0x02};
    const auto bytes = [&](std::size_t count) { return (count * bits + 7) / 8; };
    EXPECT_THAT(read_hid_layout(descriptor).reports, ElementsAre(HidLayout::Report{0, bytes(1), bytes(2), bytes(3)})) << bits;
  }
}

// A report has 64 KiB at most. Reading ends at the item with which it would have more.
TEST(HidLayout, AReportHasALargestSize) {
  const Bytes size = {0x76, 0x00, 0x80};  // 32,768 bits
  EXPECT_THAT(read_hid_layout(size + Bytes{0x95, 16, 0x81, 0x02} + kMouse).reports, ElementsAre(HidLayout::Report{0, 65'536, 0, 0}));
  EXPECT_TRUE(read_hid_layout(size + Bytes{0x95, 16, 0x81, 0x02} + kMouse).has_application(1, 2));
  EXPECT_FALSE(read_hid_layout(size + Bytes{0x95, 17, 0x81, 0x02} + kMouse).has_application(1, 2));
  EXPECT_TRUE(read_hid_layout(size + Bytes{0x95, 8, 0x81, 0x02, 0x81, 0x02} + kMouse).has_application(1, 2));
  EXPECT_FALSE(read_hid_layout(size + Bytes{0x95, 8, 0x81, 0x02, 0x81, 0x02, 0x75, 1, 0x95, 1, 0x81, 0x02} + kMouse).has_application(1, 2));
}

TEST(HidLayout, LongItemsAreSkipped) {
  EXPECT_TRUE(read_hid_layout(Bytes{0xFE, 0x02, 0x10, 0xAA, 0xBB} + kMouse).has_application(1, 2));
  EXPECT_TRUE(read_hid_layout(Bytes{0xFE, 0x00, 0x10} + kMouse).has_application(1, 2));
  EXPECT_FALSE(read_hid_layout(Bytes{0xFE, 0x08, 0x10} + kMouse).has_application(1, 2)) << "longer than all that follows";
  EXPECT_TRUE(read_hid_layout(kMouse + Bytes{0xFE}).has_application(1, 2));
  EXPECT_TRUE(read_hid_layout(kMouse + Bytes{0xFE, 0x01}).has_application(1, 2));
}

TEST(HidLayout, AFlawEndsTheReading) {
  for (const Bytes& flaw :
       {Bytes{0x85, 0x00}, Bytes{0x86, 0x00, 0x01}, Bytes{0xB4}, Bytes{0xC0}, repeated({0xA4}, 65), repeated({0xA1, 0x00}, 65)}) {
    EXPECT_TRUE(read_hid_layout(flaw + kMouse).applications.empty()) << int{flaw[0]};
  }
  EXPECT_TRUE(read_hid_layout(Bytes{0x85, 0x01} + kMouse).has_application(1, 2));
  EXPECT_TRUE(read_hid_layout(Bytes{0x85, 0xFF} + kMouse).has_application(1, 2));
  EXPECT_TRUE(read_hid_layout(repeated({0xA4}, 64) + kMouse).has_application(1, 2));
  EXPECT_TRUE(read_hid_layout(repeated({0xA1, 0x00}, 64) + repeated({0xC0}, 64) + kMouse).has_application(1, 2));
}

TEST(HidLayout, AReportIsFoundByItsNumber) {
  const HidLayout layout = read_hid_layout(hapton_hid_descriptor);
  ASSERT_NE(layout.find_report(HAPTON_HID_FORCE_ID), nullptr);
  EXPECT_EQ(layout.find_report(HAPTON_HID_FORCE_ID)->output_bytes, HAPTON_HID_FORCE_BYTES - 1U);
  EXPECT_EQ(layout.find_report(9), nullptr);
  EXPECT_FALSE(layout.has_application(kHaptonHidUsagePage, kHaptonHidUsage + 1));
}

TEST(HidLayout, ADescriptorCutOffAnywhereGivesWhatCameBefore) {
  const Bytes whole(std::begin(hapton_hid_descriptor), std::end(hapton_hid_descriptor));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const HidLayout layout = read_hid_layout(std::span(whole).first(size));
    EXPECT_LE(layout.reports.size(), 4U);
    EXPECT_EQ(layout.applications.size(), size >= 7 ? 1U : 0U) << size;
  }
}

TEST(HidLayout, AnyBytesAreSafeAndNoReportIsHuge) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 20'000; ++trial) {
    Bytes bytes(random() % 96);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    for (const HidLayout::Report& report : read_hid_layout(bytes).reports) {
      EXPECT_LE(std::max({report.input_bytes, report.output_bytes, report.feature_bytes}), std::size_t{1} << 16);
    }
  }
}

}  // namespace
}  // namespace hapton
