#include "hid/hid_catalog.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

HidKind kind_of(const HidCatalogEntry* entry) { return entry == nullptr ? HidKind::vendor_driver : entry->kind; }

TEST(HidCatalog, AHaptonHidDeviceIsFoundByItsUsageWhateverTheMaker) {
  EXPECT_EQ(kind_of(find_in_hid_catalog(0xcafe, 0x4001, kHaptonHidUsagePage, kHaptonHidUsage)), HidKind::hapton_hid);
  EXPECT_EQ(find_in_hid_catalog(0xcafe, 0x4001, kHaptonHidUsagePage, 2), nullptr);
}

TEST(HidCatalog, WoodenHapticsIsFoundByItsIds) {
  EXPECT_EQ(kind_of(find_in_hid_catalog(0x1234, 0x0006)), HidKind::wooden_haptics);
  EXPECT_EQ(kind_of(find_in_hid_catalog(0x1234, 0x0006, 0xffab, 0x0200)), HidKind::wooden_haptics);
  EXPECT_EQ(find_in_hid_catalog(0x1234, 0x0007), nullptr);
}

TEST(HidCatalog, OfAReceiversInterfacesOnlyTheMultiAxisOneIsASpaceMouse) {
  EXPECT_EQ(kind_of(find_in_hid_catalog(0x256f, 0xc652, 0x01, 0x08)), HidKind::space_mouse);
  EXPECT_EQ(find_in_hid_catalog(0x256f, 0xc652, 0x01, 0x06), nullptr);
  EXPECT_EQ(kind_of(find_in_hid_catalog(0x256f, 0xc652)), HidKind::space_mouse) << "where the usage is not known, the ids decide";
}

TEST(HidCatalog, ALogitechMouseIsNoSpaceMouse) { EXPECT_EQ(find_in_hid_catalog(0x046d, 0xc077, 0x01, 0x02), nullptr); }

TEST(HidCatalog, EveryEntryHasAName) {
  for (const HidCatalogEntry& entry : hid_catalog()) EXPECT_FALSE(entry.name.empty());
}

}  // namespace
}  // namespace hapton
