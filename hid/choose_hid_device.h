#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "hid/hid_catalog.h"
#include "hid/hid_transport.h"

namespace hapton {

// The entry of a device in the catalog, found by its ids and by any of its usages; null if it has none. RT: yes.
const HidCatalogEntry* find_in_hid_catalog(const HidDescription& device) noexcept;

// Finds the device of that kind with that id: a serial number, the path of its node ("/dev/hidraw0") or its index among the devices of its
// kind ("0").
// An empty id: the only device of that kind. Error, one line: none of that kind, none with that id, or several and no id; the last two list
// the devices. RT: no.
Result<HidDescription> choose_hid_device(std::span<const HidDescription> devices, HidKind kind, std::string_view id);

// Whether `devices` has another one, at another node, that looks the same as `chosen`. RT: no.
bool has_twin(std::span<const HidDescription> devices, const HidDescription& chosen);

// Finds the device that was chosen before; it may have been unplugged and have another node now. If several devices look the same, or
// had_twin, only one at the same node counts, since another one may not be the chosen device. Error: no device looks like the chosen one,
// or several do or did, and none of them is at its node. RT: no.
Result<HidDescription> find_hid_device_again(std::span<const HidDescription> devices, const HidDescription& chosen, HidKind kind,
                                             bool had_twin);

// Chooses the device that a program opens again and again: at first the device with that id, and after it was opened only the same one.
// Another device that looks the same and was plugged in when this one was opened or unplugged is not mistaken for it. RT: no. Threads: one.
class HidChoice {
 public:
  HidChoice(HidKind kind, std::string id) : kind_(kind), id_(std::move(id)) {}

  // Chooses among the devices that are plugged in now. Error: one line.
  Result<HidDescription> choose(std::span<const HidDescription> devices) const;
  // To be called when the chosen device was opened. devices: those that were plugged in then.
  void note_opened(const HidDescription& device, std::span<const HidDescription> devices);
  // To be called when the device was unplugged. devices: those that are still plugged in. If this process was stopped meanwhile, the device
  // itself may be back among them, at another node: then it counts as a twin, and the program must be started again.
  void note_gone(std::span<const HidDescription> devices);

 private:
  HidKind kind_;
  std::string id_;
  std::optional<HidDescription> opened_;
  bool had_twin_ = false;
};

// Order by the number of the node, which gives each device its place among its kind: hidraw10 follows hidraw9.
bool is_listed_before(const HidDescription& a, const HidDescription& b) noexcept;

// Whether both descriptions fit the same interface of the same piece of hardware. Their nodes are not compared, because a device that was
// unplugged may get another one.
bool is_same_device(const HidDescription& a, const HidDescription& b) noexcept;

}  // namespace hapton
