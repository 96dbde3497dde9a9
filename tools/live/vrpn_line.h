#pragma once

#include <memory>
#include <string_view>

#include "tools/live/marker_line.h"

namespace hapton {

// A button of a VRPN server as an input of `hapton mark --line`: "vrpn:NAME@HOST:BUTTON". HOST may be HOST:PORT; BUTTON is VRPN's number,
// 0 to 31. The prefix of such a text:
constexpr std::string_view kVrpnLine = "vrpn:";

// Error, one line: the text does not have that form. RT: no.
Result<LineInput> parse_vrpn_line(std::string_view text);

// If the connection is lost, it is made again by itself; until the server reports the button again, the line keeps its level. Waits up to 3
// s for the server. Error, one line: no such host, or no VRPN server replies from it. RT: no.
Result<std::unique_ptr<DigitalLine>> open_vrpn_line(const LineInput& input);

}  // namespace hapton
