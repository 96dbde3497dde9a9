#include "io_node/io_options.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

#include "devices/device_maker.h"
#include "link/link_key.h"
#include "link/messages.h"
#include "runtime/config.h"
#include "runtime/flag_checks.h"
#include "runtime/standard_streams.h"

namespace hapton {
namespace {

constexpr int kBadCommandLine = 2;

// The first flag on the command line that is for one device; with --devices it belongs in the file.
std::optional<std::string> find_flag_of_one_device(const CLI::App& app) {
  for (const char* flag : {"--device",
                           "--device-id",
                           "--device-file",
                           "--trajectory",
                           "--loop",
                           "--seed",
                           "--max-force",
                           "--max-slew",
                           "--max-torque",
                           "--continuous-force",
                           "--max-speed",
                           "--dead-mans-switch",
                           "--hold-button",
                           "--clutch-button",
                           "--passive-mass",
                           "--passive-damping",
                           "--passive-friction",
                           "--passive-step",
                           "--bind",
                           "--metrics",
                           "--vrpn",
                           "--vrpn-name",
                           "--record",
                           "--cpu"}) {
    if (app.count(flag) > 0) return flag;
  }
  return std::nullopt;
}

// Accepts the name of a kind of device, or plugin:FILE.so.
CLI::Validator known_device() {
  const CLI::IsMember is_name(device_names());
  const auto check = [is_name](std::string& word) {
    std::string kind(kind_of(word));
    return is_name(kind);
  };
  return {check, is_name.get_description()};
}

// Values that are parsed once the whole command line has been read.
struct IoWords {
  std::string realtime = "try";
  std::string watchdog = "try";
  std::string touch = "auto";
};

// Flags for the address at which io_node listens and the device that it drives.
void add_device_options(CLI::App& app, IoOptions& options) {
  app.add_option("--bind", options.bind, "Where to listen: ADDRESS:PORT; 0.0.0.0:4950 for a LAN, port 0: any free one")
      ->capture_default_str();
  app.add_option("--key", options.key_file, kKeyHelp);
  app.add_option("--device", options.device.name, describe_devices())->check(known_device())->capture_default_str();
  app.add_option("--devices", options.devices_file, "TOML file that describes several devices, each with its own hub (docs/devices.md)");
  app.add_option("--device-id", options.device.id,
                 "Serial number, path, index or the vendor's name for it (needed if several are plugged in; see hapton doctor)");
  app.add_option("--device-file", options.device.file, "TOML with the device's own parameters (docs/devices.md)");
  app.add_option(
      "--trajectory", options.device.trajectory,
      "CSV of the motion that is replayed (replay), or that the simulated hand follows: t_s,x_m,y_m,z_m[,qw,qx,qy,qz][,buttons]");
  app.add_flag("--loop", options.device.loop,
               "Repeat the trajectory; otherwise a replay ends with it, and the simulated hand stays at its last row");
}

void add_run_options(CLI::App& app, IoOptions& options) {
  app.add_option("--rate", options.rate_hz, "Servo rate, Hz")->check(between(kMinServoRateHz, kMaxServoRateHz))->capture_default_str();
  app.add_option("--vision-rate", options.vision_rate_hz,
                 "Largest rate of probe states to each vision node, Hz; a node gets no more than it draws; 0: none")
      ->check(between(0.0, kMaxServoRateHz))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "End after this long, s; 0: when stopped (Ctrl-C)")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
  app.add_option("--out", options.out, "Folder for report.json and latency.csv, written at the end, on SIGUSR1 and when a tool requests it")
      ->check(folder_to_write());
  app.add_option("--seed", options.device.seed, "Seed of the simulated hand's script")->capture_default_str();
}

void add_limit_options(CLI::App& app, IoOptions& options) {
  app.add_option("--max-force", options.device.max_force_n, "Tighter limit on the force, N; 0: no force at all (default: the device's own)")
      ->check(between(0.0, 1e3));
  app.add_option("--max-slew", options.device.max_slew_n_per_s, "Tighter rate limit on the force, N/s (0: the device's own)")
      ->check(between(0.0, 1e6));
  app.add_option("--max-torque", options.device.max_torque_nm, "Tighter limit on the torque, N m; 0: no torque (default: the device's own)")
      ->check(between(0.0, 1e3));
  app.add_option("--continuous-force", options.device.continuous_force_n, "Tighter continuous rating, N (0: the device's own)")
      ->check(between(0.0, 1e3));
  app.add_option("--max-speed", options.device.max_speed_m_per_s,
                 "Tighter limit on the device's speed, m/s: beyond it a fault is latched (0: the device's own)")
      ->check(between(0.0, 100.0));
}

void add_button_options(CLI::App& app, IoOptions& options) {
  auto* dead_mans_switch = app.add_option("--dead-mans-switch", options.device.dead_mans_switch,
                                          "Dead man's switch: force only while this button is held; 1: the first; 0: none")
                               ->check(between(0, 32));
  // The flag's old name counts buttons from 0; all other flags count from 1.
  auto* const hold_button =
      app.add_option_function<int>(
             "--hold-button",
             [&options](int button) {
               print_text(stderr, "io_node: --hold-button {} is now --dead-mans-switch {}: like all buttons, it counts from 1\n", button,
                          button + 1);
               options.device.dead_mans_switch = button + 1;
             },
             "Old name of --dead-mans-switch, counted from 0")
          ->check(between(-1, 31))
          ->group("");
  hold_button->excludes(dead_mans_switch);
  dead_mans_switch->remove_excludes(hold_button);  // CLI11 sets both directions, and --help would list a hidden option as an empty name
  app.add_option(
         "--clutch-button", options.device.clutch_button,
         "Clutch: while this button is held the probe stands still, without force, and the hand can be moved back; 1: the first; 0: none")
      ->check(between(0, 32));
}

void add_passivity_options(CLI::App& app, IoOptions& options) {
  auto* passive =
      app.add_option("--passive-mass", options.device.passive_mass_kg,
                     "Passivity controller: give the hand no more energy than it put in; apparent mass of the device, kg; 0: off")
          ->check(between(0.0, 100.0));
  app.add_option("--passive-damping", options.device.passive_damping_ns_per_m,
                 "The device's own damping, for --passive-mass, N s/m (0: unknown)")
      ->check(between(0.0, 1000.0))
      ->needs(passive);
  app.add_option("--passive-friction", options.device.passive_friction_n, "The device's own friction, for --passive-mass, N (0: unknown)")
      ->check(between(0.0, 100.0))
      ->needs(passive);
  app.add_option("--passive-step", options.device.passive_position_step_m,
                 "Position step of the device's encoders, for --passive-mass, m (0: none)")
      ->check(between(0.0, 0.01))
      ->needs(passive);
}

void add_record_options(CLI::App& app, IoOptions& options) {
  app.add_option("--echo-probe", options.echo_probe, "HOST:PORT of a responder (hapton echo): measure the bare UDP echo in the same run");
  app.add_option("--record", options.record, "Record the whole session into this file: every datagram, cycle and fault (hapton session)")
      ->check(file_to_write());
  app.add_option("--flight", options.flight,
                 "Folder for flight records, the last 2 s before a fault; off: none (default: OUT/flight, without --out the state folder)");
}

void add_cycle_options(CLI::App& app, IoOptions& options) {
  app.add_option("--overrun", options.overrun,
                 "When a cycle is missed: skip it, catch-up (run up to 10 late ones at once), or stop the session")
      ->check(CLI::IsMember({"skip", "catch-up", "stop"}))
      ->capture_default_str();
  app.add_option("--spin", options.spin_share,
                 "Largest share of a period that the loop may spin before its tick; 0: it sleeps until the tick")
      ->check(between(0.0, 0.5))
      ->capture_default_str();
  app.add_option(
         "--spin-reply", options.reply_spin_us,
         "Longest time to spin for each force before the loop sleeps, us, where that saves time (docs/realtime.md); 0: it sleeps at once")
      ->check(between(0.0, 1000.0))
      ->capture_default_str();
  app.add_option("--echo-size", options.echo_bytes, "Bytes of the bare echo's datagrams; 0: those of a device sample")
      ->check(between(0, kMaxDatagramBytes))
      ->capture_default_str();
}

// Flags for what io_node serves besides forces, and for where forces are computed.
void add_server_options(CLI::App& app, IoOptions& options, IoWords& words) {
  app.add_option("--metrics", options.metrics,
                 "Serve the statistics by HTTP at this loopback address, for Prometheus: 127.0.0.1:9464 (default: off)");
  app.add_option("--vrpn", options.vrpn,
                 "Show the stylus to VRPN programs at this address, TCP and UDP: 127.0.0.1:3883 (default: off; see docs/vrpn.md)");
  app.add_option("--vrpn-name", options.vrpn_name, "Name of the device for VRPN programs, which open NAME@HOST")->capture_default_str();
  app.add_option("--touch", words.touch,
                 "Where forces are computed: by the haptics node (remote), by io_node from the parts of the scene that it gets (patch), or "
                 "as the round trip requires (auto; docs/remote.md)")
      ->check(CLI::IsMember({"remote", "patch", "auto"}))
      ->capture_default_str();
}

void add_realtime_options(CLI::App& app, IoOptions& options, IoWords& words) {
  app.add_option("--rt", words.realtime, "Real-time scheduling: try, require or off")
      ->check(CLI::IsMember({"try", "require", "off"}))
      ->capture_default_str();
  app.add_option("--rt-priority", options.realtime.priority, "SCHED_FIFO priority, 0: ordinary thread")
      ->check(between(0, 99))
      ->capture_default_str();
  app.add_option("--cpu", options.realtime.cpu, "Pin the servo loop to this CPU, -1: any")->check(between(-1, 4095))->capture_default_str();

  app.add_option("--watchdog", words.watchdog,
                 "Watchdog process that releases the force when this one is frozen or killed: try, require or off")
      ->check(CLI::IsMember({"try", "require", "off"}))
      ->capture_default_str();
}

// False: some flags exclude each other, and one line on stderr says which.
bool fit_together(const CLI::App& app, const IoOptions& options) {
  if (!options.devices_file.empty()) {
    if (const auto flag = find_flag_of_one_device(app)) {
      print_text(stderr, "io_node: {0} is for one device; with --devices write it into each [[device]] of {1} and leave {0} out\n", *flag,
                 options.devices_file);
      return false;
    }
  }
  if (options.device.clutch_button > 0 && options.device.clutch_button == options.device.dead_mans_switch) {
    print_text(stderr, "io_node: --clutch-button {} is also the button of --dead-mans-switch: take another one\n",
               options.device.clutch_button);
    return false;
  }
  return true;
}

}  // namespace

std::variant<IoOptions, int> parse_io_options(int argc, const char* const* argv) {
  IoOptions options;
  IoWords words;
  CLI::App app{"Drives the force-feedback device, limits every force, and is the hub that the other nodes join.", "io_node"};
  add_device_options(app, options);
  add_run_options(app, options);
  add_limit_options(app, options);
  add_button_options(app, options);
  add_passivity_options(app, options);
  add_record_options(app, options);
  add_cycle_options(app, options);
  add_server_options(app, options, words);
  add_realtime_options(app, options, words);

  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  if (!fit_together(app, options)) return kBadCommandLine;
  options.touch = words.touch == "remote" ? TouchChoice::remote : words.touch == "patch" ? TouchChoice::patch : TouchChoice::automatic;
  options.realtime.mode = *parse_realtime_mode(words.realtime);
  options.watchdog = *parse_realtime_mode(words.watchdog);
  return options;
}

}  // namespace hapton
