#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/hub_client.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// What a tool changes in a running system. Empty or 0: stays as it is.
struct SettingsChange {
  double rate_hz = 0.0;          // of the servo
  std::string method = {};       // as `haptics_node --method`; "plugin": the plug-in that it was started with
  std::string object = {};       // name in the scene of the object whose material changes; empty: all objects
  MaterialChange material = {};  // fields == 0: none
  bool writes_report = false;    // io_node writes its report now
  bool resets_faults = false;    // needs an operator's key
};

// The messages of a change, with random request numbers.
struct SettingsRequest {
  Settings settings;
  std::optional<MaterialRequest> material;
  bool has_settings = false;  // false: there is only the material
};
// Error, one line: a name that is too long. RT: no.
Result<SettingsRequest> make_settings_request(const SettingsChange& change);

// Sends a request and waits until hub and haptics node have confirmed it; a reset of faults and a request for a report are not confirmed.
// Result: what is in use now, in one line. Error, one line: who does not confirm it, or why it was rejected; the rest of the request is not
// undone. Other messages that arrive meanwhile are dropped. hub: its address, for these lines. Pre: the client has joined as a tool. Time:
// up to 70 s where a method has to be built. RT: no.
Result<std::string> apply_settings(HubClient& client, const Clock& clock, const SettingsRequest& request, std::string_view hub);

}  // namespace hapton
