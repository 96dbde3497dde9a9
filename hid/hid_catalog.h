#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace hapton {

enum class HidKind : std::uint8_t {
  wooden_haptics,  // driven by --device wooden-haptics
  hapton_hid,      // driven by --device hapton-hid: a device of any maker, found by its usage
  space_mouse,     // driven by --device spacemouse, and the knob box of vision_node
  vendor_driver,   // a force-feedback device that only its vendor's library can drive
};

// One device, or one family of them. A zero pid matches every product of the vendor, a zero vid every vendor, a zero usage_page any usage.
// Receivers and keyboards have several interfaces with the same ids, so a usage that the entry gives must match as well.
struct HidCatalogEntry {
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;
  std::uint16_t usage_page = 0;
  std::uint16_t usage = 0;
  HidKind kind = HidKind::vendor_driver;
  std::string_view name;
};

// The usage of Hapton HID devices (docs/hid.md).
constexpr std::uint16_t kHaptonHidUsagePage = 0xFF48;
constexpr std::uint16_t kHaptonHidUsage = 0x0001;

// All HID devices that Hapton knows, in the order of the search: the first entry that matches a device counts. RT: yes.
std::span<const HidCatalogEntry> hid_catalog() noexcept;

// The entry of a device in the catalog; null if it has none. A usage_page of 0 means that the usage is not known: then the ids alone
// decide. RT: yes.
const HidCatalogEntry* find_in_hid_catalog(std::uint16_t vid, std::uint16_t pid, std::uint16_t usage_page = 0,
                                           std::uint16_t usage = 0) noexcept;

// Name of a kind: "WoodenHaptics", "Hapton HID", "SpaceMouse" or "vendor's driver".
std::string_view to_string(HidKind kind) noexcept;

}  // namespace hapton
