#include "hid/choose_hid_device.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

namespace hapton {
namespace {

std::optional<std::size_t> parse_index(std::string_view id) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), index);
  // Serial numbers may consist of digits too, so only a text of one or two digits is an index.
  if (error != std::errc() || end != id.data() + id.size() || id.size() > 2) return std::nullopt;
  return index;
}

std::string list(const std::vector<HidDescription>& devices) {
  std::string text;
  for (const HidDescription& device : devices) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", device.path, device.serial.empty() ? "no serial number" : device.serial);
  }
  return text;
}

std::string_view what_to_do(HidKind kind) {
  switch (kind) {
    case HidKind::wooden_haptics:
      return "plug it in, switch its motor drivers on";
    case HidKind::hapton_hid:
      return "plug one in (docs/hid.md says how it is recognised)";
    case HidKind::space_mouse:
      return "plug it or its receiver in";
    case HidKind::vendor_driver:
      break;
  }
  return "plug it in";
}

}  // namespace

const HidCatalogEntry* find_in_hid_catalog(const HidDescription& device) noexcept {
  if (const auto* entry = find_in_hid_catalog(device.vid, device.pid, device.usage_page, device.usage)) return entry;
  for (const HidLayout::Usage& usage : device.layout.applications) {
    if (const auto* entry = find_in_hid_catalog(device.vid, device.pid, usage.page, usage.usage)) return entry;
  }
  return nullptr;
}

Result<HidDescription> choose_hid_device(std::span<const HidDescription> devices, HidKind kind, std::string_view id) {
  std::vector<HidDescription> of_kind;
  for (const HidDescription& device : devices) {
    const HidCatalogEntry* entry = find_in_hid_catalog(device);
    const bool is_listed =
        std::any_of(of_kind.begin(), of_kind.end(), [&](const HidDescription& known) { return known.path == device.path; });
    if (entry != nullptr && entry->kind == kind && !is_listed) of_kind.push_back(device);
  }
  if (of_kind.empty()) {
    return fail("no {} is plugged in, among {} HID devices; {}, or see what is there with: hapton doctor", to_string(kind), devices.size(),
                what_to_do(kind));
  }
  if (id.empty()) {
    if (of_kind.size() == 1) return of_kind.front();
    return fail("{} {} devices are plugged in; say which by serial number or path: {}", of_kind.size(), to_string(kind), list(of_kind));
  }
  const auto named =
      std::find_if(of_kind.begin(), of_kind.end(), [&](const HidDescription& device) { return device.serial == id || device.path == id; });
  if (named != of_kind.end()) return *named;
  if (const auto index = parse_index(id); index && *index < of_kind.size()) return of_kind[*index];
  return fail("no {} has the serial number, path or place '{}'; plugged in are: {}", to_string(kind), id, list(of_kind));
}

bool has_twin(std::span<const HidDescription> devices, const HidDescription& chosen) {
  return std::ranges::any_of(devices, [&](const HidDescription& d) { return d.path != chosen.path && is_same_device(d, chosen); });
}

Result<HidDescription> find_hid_device_again(std::span<const HidDescription> devices, const HidDescription& chosen, HidKind kind,
                                             bool had_twin) {
  std::vector<HidDescription> candidates(devices.begin(), devices.end());
  std::erase_if(candidates, [&](const HidDescription& device) { return !is_same_device(device, chosen); });
  if (candidates.empty()) {
    return fail("the {} used before ({}) is not among the {} HID devices that are plugged in; plug it in again", to_string(kind),
                chosen.serial.empty() ? "no serial number" : chosen.serial, devices.size());
  }
  if (candidates.size() == 1 && !had_twin) return choose_hid_device(candidates, kind, "");
  const bool is_at_its_node = std::ranges::any_of(candidates, [&](const HidDescription& device) { return device.path == chosen.path; });
  if (is_at_its_node) return choose_hid_device(candidates, kind, chosen.path);
  return fail("the {} from before was {}; a device that looks the same may be another one: {}; start this program again to use it",
              to_string(kind), chosen.path, list(candidates));
}

Result<HidDescription> HidChoice::choose(std::span<const HidDescription> devices) const {
  return opened_ ? find_hid_device_again(devices, *opened_, kind_, had_twin_) : choose_hid_device(devices, kind_, id_);
}

void HidChoice::note_opened(const HidDescription& device, std::span<const HidDescription> devices) {
  opened_ = device;
  had_twin_ = had_twin_ || has_twin(devices, device);
}

void HidChoice::note_gone(std::span<const HidDescription> devices) { had_twin_ = had_twin_ || (opened_ && has_twin(devices, *opened_)); }

bool is_listed_before(const HidDescription& a, const HidDescription& b) noexcept {
  return a.path.size() != b.path.size() ? a.path.size() < b.path.size() : a.path < b.path;
}

bool is_same_device(const HidDescription& a, const HidDescription& b) noexcept {
  return a.vid == b.vid && a.pid == b.pid && a.serial == b.serial && a.usage_page == b.usage_page && a.usage == b.usage;
}

}  // namespace hapton
