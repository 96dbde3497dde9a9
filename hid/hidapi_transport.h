#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hid/hid_catalog.h"
#include "hid/hid_transport.h"

namespace hapton {

// All HID devices of any vendor that the system shows through hidraw: one entry for each of their nodes, in the order of is_listed_before.
// Needs no permission. RT: no. There is no error; on a system without HID the list is empty. Threads: any.
std::vector<HidDescription> list_hid_devices();

// The report descriptor of a node ("/dev/hidraw0"), from the folder `classes` of all such nodes; empty if it cannot be read. RT: no.
HidLayout read_hidraw_layout(const std::string& path, const std::filesystem::path& classes = "/sys/class/hidraw");

// Converts what hidapi returned for a read, and its errno: a wait that a signal ended does not count as unplugged. RT: yes.
HidRead to_hid_read(int returned, int error) noexcept;

// exclusive: for force devices, which only one hand in one program may drive: opening fails while another one has the node exclusively
// (device_lock.h).
enum class HidSharing : std::uint8_t { shared, exclusive };
// Opens a node. The system creates a node before it grants access, so denied access is retried for a second. Error: one line with the
// remedy. on_gone: called by HidTransport::note_gone if a read has found the device unplugged. RT: set-up only.
Result<std::unique_ptr<HidTransport>> open_hid_device(const HidDescription& device, HidSharing sharing = HidSharing::exclusive,
                                                      std::function<void()> on_gone = {});

// Makes an opener that opens the device that choose_hid_device finds, and after that only the same one again (HidChoice).
HidOpener make_hid_opener(HidKind kind, std::string id);

}  // namespace hapton
