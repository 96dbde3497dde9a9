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

// The entry of a device in the catalog, by its ids and by every usage that it has; null if it has none. RT: yes.
const HidCatalogEntry* find_in_hid_catalog(const HidDescription& device) noexcept;

// The device of that kind with that id: its serial number, its path ("/dev/hidraw0") or its place among its kind ("0", "1").
// An empty id: the only one there is. Error: none of that kind, none with that id, or several and no id; the line lists what there is.
// RT: no.
Result<HidDescription> choose_hid_device(std::span<const HidDescription> devices, HidKind kind, std::string_view id);

// Whether another one of these looks the same as this one. RT: no.
bool has_twin(std::span<const HidDescription> devices, const HidDescription& chosen);

// The device that was chosen before, now that it may have been unplugged: its node may have another name now, but must not where several
// look the same, or did: the one that is left is not the one that was chosen. Error: it is not there, whatever else is, or it had a twin
// and none is at its node. RT: no.
Result<HidDescription> find_hid_device_again(std::span<const HidDescription> devices, const HidDescription& chosen, HidKind kind,
                                             bool had_twin);

// What a program opens again and again: at first the device with that id, and once it could be opened only the same one. One that looks the
// same and was there beside it, when it was opened or when it went, is not taken for it. RT: no. Threads: one.
class HidChoice {
 public:
  HidChoice(HidKind kind, std::string id) : kind_(kind), id_(std::move(id)) {}

  // Among what is plugged in now. Error: one line.
  Result<HidDescription> choose(std::span<const HidDescription> devices) const;
  // It could be opened, when these were plugged in.
  void note_opened(const HidDescription& device, std::span<const HidDescription> devices);
  // It has just gone, and these are plugged in still. If this process was stopped meanwhile, one of them may be the device itself: then it
  // counts as a twin, and the program must be started again.
  void note_gone(std::span<const HidDescription> devices);

 private:
  HidKind kind_;
  std::string id_;
  std::optional<HidDescription> opened_;
  bool had_twin_ = false;
};

// By the number of its node, from which a device without a name has its place: hidraw10 follows hidraw9.
bool is_listed_before(const HidDescription& a, const HidDescription& b) noexcept;

// Whether both describe the same interface of the same piece of hardware, as far as the descriptions show; its node may have changed after
// it was unplugged.
bool is_same_device(const HidDescription& a, const HidDescription& b) noexcept;

}  // namespace hapton
