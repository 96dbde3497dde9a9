#pragma once

#include <string>
#include <vector>

#include "hid/hid_catalog.h"
#include "hid/hid_transport.h"

namespace hapton {

// Every HID device that the system shows through hidraw, whoever made it; one entry for each of its nodes, sorted by path. Needs no
// permission. RT: no. Error: never; a system without HID has none.
std::vector<HidDescription> list_hid_devices();

// Opens a node. The system makes it before it grants the right to it: a rejection is asked about again for a second.
// Error: one line with the remedy. RT: set-up only.
Result<std::unique_ptr<HidTransport>> open_hid_device(const HidDescription& device);

// Opens the device that choose_hid_device finds, and after that only the same one again.
HidOpener make_hid_opener(HidKind kind, std::string id);

}  // namespace hapton
