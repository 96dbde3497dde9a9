#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hapton {

// The contents of a HID report descriptor that are needed to recognise a device and to distinguish its variants.
struct HidLayout {
  struct Usage {
    std::uint16_t page = 0;
    std::uint16_t usage = 0;
    friend bool operator==(const Usage&, const Usage&) = default;
  };
  // Sizes of a report as hidraw reads and writes it, without the byte of its id; 0: there is no report of that kind.
  struct Report {
    std::uint8_t id = 0;  // 0: the device's reports have no ids
    std::size_t input_bytes = 0;
    std::size_t output_bytes = 0;
    std::size_t feature_bytes = 0;
    friend bool operator==(const Report&, const Report&) = default;
  };

  std::vector<Usage> applications;  // top-level collections, in order
  std::vector<Report> reports;      // in the order of their first field

  bool has_application(std::uint16_t page, std::uint16_t usage) const noexcept;
  const Report* find_report(std::uint8_t id) const noexcept;
};

// Reads a report descriptor. Everything after a flaw is left out; any bytes are safe as input. RT: no, it allocates.
// Source: Device Class Definition for HID 1.11, section 6.2.2.
HidLayout read_hid_layout(std::span<const std::uint8_t> descriptor);

}  // namespace hapton
