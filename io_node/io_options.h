#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "devices/device_settings.h"
#include "io_node/touch_chooser.h"
#include "link/address.h"
#include "runtime/realtime.h"

namespace hapton {

struct IoOptions {
  std::string name;  // name of the device if there are several (--devices); empty: it is the only one
  std::string bind = "127.0.0.1:" + std::to_string(kDefaultHubPort);
  DeviceSettings device;
  std::string devices_file;  // file that describes several devices; empty: only the device above
  double rate_hz = 1000.0;
  double vision_rate_hz = 240.0;
  double seconds = 0.0;  // 0: until stopped
  std::string out;       // folder for reports; empty: none
  std::string record;    // file for the whole session; empty: none
  std::string flight;    // folder for flight records; empty: see find_flight_folder; "off": none
  std::string overrun = "skip";
  double spin_share = 0.1;       // largest share of a period that the loop may spin before its tick
  double reply_spin_us = 100.0;  // the longest time to spin for a force
  std::string metrics;           // address of the HTTP metrics; empty: off
  std::string vrpn;              // address of the VRPN server; empty: off
  std::string vrpn_name = "Phantom0";
  std::size_t echo_bytes = 0;  // size of the bare echo's datagrams; 0: that of a DeviceState
  std::string echo_probe;      // address of the responder of the bare echo; empty: not measured
  std::string key_file;        // empty: the user's own key, on loopback
  RealtimeSettings realtime;
  TouchChoice touch = TouchChoice::automatic;
  RealtimeMode watchdog = RealtimeMode::attempt;  // the watchdog process: try, require or off
};

// Prefix of the log lines of one of several devices: "NAME: "; empty for a single device.
inline std::string name_prefix(const IoOptions& options) { return options.name.empty() ? "" : options.name + ": "; }

// The program's options, or the exit code to leave main with (help, or an error that has been printed). RT: set-up only.
std::variant<IoOptions, int> parse_io_options(int argc, const char* const* argv);

}  // namespace hapton
