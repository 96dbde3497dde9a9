#pragma once

#include <memory>
#include <string_view>

#include "tools/live/marker_line.h"

namespace hapton {

// A button of a VRPN server as a line: "vrpn:NAME@HOST:BUTTON", with HOST or HOST:PORT, and BUTTON from 0 to 31 as VRPN counts them.
constexpr std::string_view kVrpnLine = "vrpn:";

// Error, one line: not of that form. RT: no.
Result<LineInput> parse_vrpn_line(std::string_view text);

// Off while there is no connection, which is made again by itself. Error, one line: no such host, or no VRPN server replies there.
Result<std::unique_ptr<DigitalLine>> open_vrpn_line(const LineInput& input);

}  // namespace hapton
