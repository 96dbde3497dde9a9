#include "io_node/devices_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "core/math/turn_by_degrees.h"
#include "devices/device_maker.h"
#include "link/messages.h"
#include "runtime/toml_reader.h"
#include "runtime/writable_path.h"

namespace hapton {
namespace {

constexpr double kFarthestM = 10.0;  // no two devices of one person are farther apart
// The same limits as those of io_node's flags, beyond any device that a hand may hold.
constexpr double kMaxForceN = 1e3;
constexpr double kMaxTorqueNm = 1e3;
constexpr double kMaxSlewNPerS = 1e6;
constexpr std::int64_t kMaxSeed = std::int64_t{1} << 62;
constexpr std::size_t kLongestName = 32;

// A name is used as the name of a folder and as the prefix of log lines.
bool is_valid_name(std::string_view name) {
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_'; };
  return !name.empty() && name.size() <= kLongestName && std::all_of(name.begin(), name.end(), is_plain);
}

bool has_free_port(std::string_view bind) { return bind.ends_with(":0"); }

// The pose of the device in frame W; rotation_deg means the same as in scene files.
Pose read_place(TomlReader& reader) {
  Vec3 position_m = Vec3::Zero();
  Vec3 rotation_deg = Vec3::Zero();
  reader.read("position_m", position_m, -kFarthestM, kFarthestM);
  reader.read("rotation_deg", rotation_deg, -360.0, 360.0);
  Pose X_WB = Pose::Identity();
  X_WB.linear() = turn_by_degrees(rotation_deg).toRotationMatrix();
  X_WB.translation() = position_m;
  return X_WB;
}

// The button, counted from 1; 0: none. `hold_button`, the old name of the key, counts from 0.
int read_dead_mans_switch(TomlReader& reader, int otherwise) {
  std::int64_t button = otherwise;
  std::int64_t from_zero = button - 1;
  reader.read("dead_mans_switch", button, 0, 32);
  reader.read("hold_button", from_zero, -1, 31);
  if (!reader.has("hold_button")) return static_cast<int>(button);
  if (reader.has("dead_mans_switch")) reader.reject("hold_button", "'hold_button' is the old name of 'dead_mans_switch': leave it out");
  return static_cast<int>(from_zero + 1);
}

void allow_device_keys(TomlReader& reader) {
  reader.allow({"name",
                "device",
                "bind",
                "id",
                "file",
                "trajectory",
                "loop",
                "seed",
                "position_m",
                "rotation_deg",
                "max_force_n",
                "max_slew_n_per_s",
                "max_torque_nm",
                "continuous_force_n",
                "max_speed_m_per_s",
                "dead_mans_switch",
                "hold_button",
                "clutch_button",
                "passive_mass_kg",
                "passive_damping_ns_per_m",
                "passive_friction_n",
                "passive_position_step_m",
                "rate_hz",
                "cpu",
                "record",
                "metrics",
                "vrpn",
                "vrpn_name"});
}

void read_safety(TomlReader& reader, DeviceSettings& device) {
  reader.read("max_force_n", device.max_force_n, 0.0, kMaxForceN);
  reader.read("max_slew_n_per_s", device.max_slew_n_per_s, 0.0, kMaxSlewNPerS);
  reader.read("max_torque_nm", device.max_torque_nm, 0.0, kMaxTorqueNm);
  reader.read("continuous_force_n", device.continuous_force_n, 0.0, kMaxForceN);
  reader.read("max_speed_m_per_s", device.max_speed_m_per_s, 0.0, 100.0);
  device.dead_mans_switch = read_dead_mans_switch(reader, device.dead_mans_switch);
  std::int64_t clutch_button = device.clutch_button;
  reader.read("clutch_button", clutch_button, 0, 32);
  device.clutch_button = static_cast<int>(clutch_button);
  if (clutch_button > 0 && clutch_button == device.dead_mans_switch) {
    reader.reject("clutch_button",
                  fmt::format("'clutch_button' = {} is also the button of 'dead_mans_switch': take another one", clutch_button));
  }
  reader.read("passive_mass_kg", device.passive_mass_kg, 0.0, 100.0);
  reader.read("passive_damping_ns_per_m", device.passive_damping_ns_per_m, 0.0, 1000.0);
  reader.read("passive_friction_n", device.passive_friction_n, 0.0, 100.0);
  reader.read("passive_position_step_m", device.passive_position_step_m, 0.0, 0.01);
}

IoOptions read_device(TomlReader& reader, const IoOptions& common) {
  IoOptions options = common;
  allow_device_keys(reader);
  for (const char* key : {"name", "device", "bind"}) reader.require(key);
  reader.read("name", options.name);
  if (!is_valid_name(options.name)) {
    reader.reject("name", fmt::format("'name' is '{}': give 1 to {} characters of a-z, 0-9, - and _; it is also the name of a folder",
                                      options.name, kLongestName));
  }
  reader.read("device", options.device.name);
  const auto names = device_names();
  if (std::find(names.begin(), names.end(), kind_of(options.device.name)) == names.end()) {
    reader.reject("device", fmt::format("unknown device '{}'; choose one of {}", options.device.name, fmt::join(names, ", ")));
  }
  reader.read("bind", options.bind);
  reader.read("id", options.device.id);
  reader.read_path("file", options.device.file);
  reader.read_path("trajectory", options.device.trajectory);
  reader.read("loop", options.device.loop);
  auto seed = static_cast<std::int64_t>(options.device.seed);
  reader.read("seed", seed, 0, kMaxSeed);
  options.device.seed = static_cast<std::uint64_t>(seed);
  options.device.X_WB = read_place(reader);
  read_safety(reader, options.device);
  reader.read("rate_hz", options.rate_hz, kMinServoRateHz, kMaxServoRateHz);
  std::int64_t cpu = options.realtime.cpu;
  reader.read("cpu", cpu, -1, 4095);
  options.realtime.cpu = static_cast<int>(cpu);
  reader.read_path("record", options.record);
  reader.read("metrics", options.metrics);
  reader.read("vrpn", options.vrpn);
  reader.read("vrpn_name", options.vrpn_name);
  if (!options.out.empty()) options.out = (std::filesystem::path(common.out) / options.name).string();
  return options;
}

bool takes_id(const std::string& name) {
  const auto makers = device_makers();
  const auto maker = std::find_if(makers.begin(), makers.end(), [&](const DeviceMaker& m) { return m.name == name; });
  return maker != makers.end() && maker->takes_id;
}

// Rejects what two devices must not have in common.
void check_pair(TomlReader& reader, const IoOptions& one, const IoOptions& other) {
  if (one.name == other.name) reader.reject("name", fmt::format("there are two devices '{}'; give each a name of its own", one.name));
  if (one.bind == other.bind && !has_free_port(one.bind)) {
    reader.reject("bind", fmt::format("'{}' and '{}' both listen at {}; give each a port of its own", one.name, other.name, one.bind));
  }
  // Equal names are rejected even if they name a pipe, for which is_same_output() is false: two recordings in one stream cannot be read.
  if ((!one.record.empty() && one.record == other.record) || is_same_output(one.record, other.record)) {
    reader.reject("record", fmt::format("'{}' and '{}' both record into {}; name two files", one.name, other.name, one.record));
  }
  const bool is_same_kind = one.device.name == other.device.name && takes_id(one.device.name);
  if (is_same_kind && (one.device.id.empty() || other.device.id.empty() || one.device.id == other.device.id)) {
    reader.reject(
        "id", fmt::format("'{}' and '{}' are both {}: give each an id (hapton doctor lists them)", one.name, other.name, one.device.name));
  }
}

}  // namespace

Result<std::vector<IoOptions>> read_devices_file(const std::filesystem::path& path, const IoOptions& common) {
  auto file = TomlReader::open(path);
  if (!file) return tl::unexpected(file.error());
  file->allow({"device"});
  std::vector<TomlReader> tables = file->tables("device");
  if (tables.empty()) file->reject("device", "no [[device]] found: add one for each device");
  std::vector<IoOptions> devices;
  for (TomlReader& table : tables) {
    devices.push_back(read_device(table, common));
    for (std::size_t n = 0; n + 1 < devices.size(); ++n) check_pair(table, devices[n], devices.back());
  }
  if (const auto result = file->result(); !result) return tl::unexpected(result.error());
  return devices;
}

}  // namespace hapton
