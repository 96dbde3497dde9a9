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

// Every HID device that the system shows through hidraw, of any vendor; one entry for each of its nodes, sorted by path. Needs no
// permission. RT: no. Error: never; a system without HID has none.
std::vector<HidDescription> list_hid_devices();

// The report descriptor of a node ("/dev/hidraw0"), from the system's list of such nodes; empty if it cannot be read. RT: no.
HidLayout read_hidraw_layout(const std::string& path, const std::filesystem::path& classes = "/sys/class/hidraw");

// What hidapi returned for a read, with the errno: a signal that ended the wait does not count as unplugged. RT: yes.
HidRead to_hid_read(int returned, int error) noexcept;

// A force device is one program's, and one hand's in it: an exclusive node that somebody else has exclusively is not opened
// (device_lock.h).
enum class HidSharing : std::uint8_t { shared, exclusive };
// Opens a node. The system creates it before it grants access: a denied access is retried for a second. Error: one line with the remedy.
// on_gone: called by HidTransport::note_gone of a device that a read has found unplugged. RT: set-up only.
Result<std::unique_ptr<HidTransport>> open_hid_device(const HidDescription& device, HidSharing sharing = HidSharing::exclusive,
                                                      std::function<void()> on_gone = {});

// Opens the device that choose_hid_device finds, and after that only the same one again.
HidOpener make_hid_opener(HidKind kind, std::string id);

}  // namespace hapton
