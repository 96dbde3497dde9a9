#include "hid/hid_catalog.h"

#include <algorithm>
#include <array>

namespace hapton {
namespace {

constexpr HidCatalogEntry space_mouse(std::uint16_t vid, std::uint16_t pid, std::string_view name) {
  return {vid, pid, 0x01, 0x08, HidKind::space_mouse, name};
}

// SpaceMice of 3Dconnexion: first those with Logitech's vendor id, then those with its own; from spacenavd (dev.c) and PySpaceMouse.
constexpr std::array kCatalog = {
    HidCatalogEntry{0, 0, kHaptonHidUsagePage, kHaptonHidUsage, HidKind::hapton_hid, "Hapton HID device"},
    HidCatalogEntry{0x1234, 0x0006, 0, 0, HidKind::wooden_haptics, "WoodenHaptics"},
    space_mouse(0x046d, 0xc603, "SpaceMouse Plus XT"),
    space_mouse(0x046d, 0xc605, "CADman"),
    space_mouse(0x046d, 0xc606, "SpaceMouse Classic"),
    space_mouse(0x046d, 0xc621, "SpaceBall 5000"),
    space_mouse(0x046d, 0xc623, "SpaceTraveler"),
    space_mouse(0x046d, 0xc625, "SpacePilot"),
    space_mouse(0x046d, 0xc626, "SpaceNavigator"),
    space_mouse(0x046d, 0xc627, "SpaceExplorer"),
    space_mouse(0x046d, 0xc628, "SpaceNavigator for Notebooks"),
    space_mouse(0x046d, 0xc629, "SpacePilot Pro"),
    space_mouse(0x046d, 0xc62b, "SpaceMouse Pro"),
    space_mouse(0x046d, 0xc640, "NuLOOQ"),
    space_mouse(0x256f, 0xc62e, "SpaceMouse Wireless (cable)"),
    space_mouse(0x256f, 0xc62f, "SpaceMouse Wireless (receiver)"),
    space_mouse(0x256f, 0xc631, "SpaceMouse Pro Wireless (cable)"),
    space_mouse(0x256f, 0xc632, "SpaceMouse Pro Wireless (receiver)"),
    space_mouse(0x256f, 0xc633, "SpaceMouse Enterprise"),
    space_mouse(0x256f, 0xc635, "SpaceMouse Compact"),
    space_mouse(0x256f, 0xc636, "SpaceMouse Module"),
    space_mouse(0x256f, 0xc638, "SpaceMouse Pro Wireless BT (cable)"),
    space_mouse(0x256f, 0xc63a, "SpaceMouse Wireless BT"),
    space_mouse(0x256f, 0xc641, "SpaceMouse USB"),
    space_mouse(0x256f, 0xc652, "3Dconnexion Universal Receiver"),
    HidCatalogEntry{0x16c0, 0x0486, 0, 0, HidKind::vendor_driver, "Haptikfabriken Polhem, or another Teensy with raw HID"},
    HidCatalogEntry{0x2988, 0, 0, 0, HidKind::vendor_driver, "3D Systems Touch"},
};

bool matches(const HidCatalogEntry& entry, std::uint16_t vid, std::uint16_t pid, std::uint16_t usage_page, std::uint16_t usage) noexcept {
  if (entry.vid != 0 && entry.vid != vid) return false;
  if (entry.pid != 0 && entry.pid != pid) return false;
  if (entry.usage_page == 0) return true;
  if (usage_page == 0) return entry.vid != 0;
  return entry.usage_page == usage_page && entry.usage == usage;
}

}  // namespace

std::span<const HidCatalogEntry> hid_catalog() noexcept { return kCatalog; }

const HidCatalogEntry* find_in_hid_catalog(std::uint16_t vid, std::uint16_t pid, std::uint16_t usage_page, std::uint16_t usage) noexcept {
  const auto* found = std::find_if(kCatalog.begin(), kCatalog.end(),
                                   [&](const HidCatalogEntry& entry) { return matches(entry, vid, pid, usage_page, usage); });
  return found == kCatalog.end() ? nullptr : &*found;
}

std::string_view to_string(HidKind kind) noexcept {
  switch (kind) {
    case HidKind::wooden_haptics:
      return "WoodenHaptics";
    case HidKind::hapton_hid:
      return "Hapton HID";
    case HidKind::space_mouse:
      return "SpaceMouse";
    case HidKind::vendor_driver:
      return "vendor's driver";
  }
  return "";
}

}  // namespace hapton
