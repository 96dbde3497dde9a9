#include "devices/plugin_device.h"

#include <array>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

constexpr double kMaxForceN = 1000.0;          // the same limit as io_node's flags
constexpr double kMaxTorqueNm = 1000.0;        // likewise
constexpr double kMaxNumber = 1e9;             // limit of each value without one of its own
constexpr double kQuaternionTolerance = 1e-3;  // of the squared length: single precision, or numbers with four digits

DeviceStatus to_status(std::int32_t plugin_status) noexcept {
  switch (plugin_status) {
    case HAPTON_DEVICE_READY:
      return DeviceStatus::ready;
    case HAPTON_DEVICE_AWAY:
      return DeviceStatus::away;
    case HAPTON_DEVICE_CALIBRATING:
      return DeviceStatus::calibrating;
    case HAPTON_DEVICE_ENDED:
      return DeviceStatus::ended;
    default:
      return DeviceStatus::fault;
  }
}

Vec3 to_vector(const double (&from)[3]) noexcept { return {from[0], from[1], from[2]}; }

// A length slightly off 1 is a rounding error, which is removed. Any other quaternion stays as it is, so that the governor rejects it.
Quat to_orientation(const double (&from)[4]) noexcept {
  const Quat q(from[0], from[1], from[2], from[3]);
  return std::abs(q.squaredNorm() - 1.0) < kQuaternionTolerance ? q.normalized() : q;
}

}  // namespace

PluginDevice::PluginDevice(PluginFile file, const hapton_device_api& api)
    : file_(std::move(file)), api_(api), name_("plugin " + clean_plugin_name(api.name)) {}

Result<std::unique_ptr<PluginDevice>> PluginDevice::make(const PluginChoice& choice) {
  auto file = PluginFile::open(choice);
  if (!file) return tl::unexpected(file.error());
  const auto api = file->find_device();
  if (!api) return tl::unexpected(api.error());
  std::unique_ptr<PluginDevice> made(new PluginDevice(std::move(*file), **api));
  const PluginRequest request(made->file_.choice());
  hapton_device_limits limits = {};
  if (!call_plugin([&] { made->device_ = made->api_.open(request.get(), &limits); }))
    return fail("{}: {} threw a C++ exception in open", made->file_.path(), made->name_);
  if (made->device_ == nullptr) return tl::unexpected(request.rejection(made->name_));
  if (const auto taken = made->take_limits(limits); !taken) return tl::unexpected(taken.error());
  return made;
}

PluginDevice::~PluginDevice() {
  if (device_ == nullptr) return;
  constexpr std::array<double, 3> kNone = {0.0, 0.0, 0.0};
  call_plugin([&] { api_.write(device_, last_.time_ns, kNone.data(), kNone.data()); });
  call_plugin([&] { api_.close(device_); });
}

Result<void> PluginDevice::take_limits(const hapton_device_limits& limits) {
  struct Bound {
    const char* name;
    double value;
    double most;
  };
  for (const Bound& bound :
       {Bound{"max_force_n", limits.max_force_n, kMaxForceN}, Bound{"max_slew_n_per_s", limits.max_slew_n_per_s, kMaxNumber},
        Bound{"max_stiffness_n_per_m", limits.max_stiffness_n_per_m, kMaxNumber},
        Bound{"max_torque_nm", limits.max_torque_nm, kMaxTorqueNm},
        Bound{"max_torque_slew_nm_per_s", limits.max_torque_slew_nm_per_s, kMaxNumber},
        Bound{"continuous_force_n", limits.continuous_force_n, kMaxForceN}, Bound{"peak_s", limits.peak_s, kMaxNumber},
        Bound{"max_speed_m_per_s", limits.max_speed_m_per_s, kMaxNumber}}) {
    if (!(bound.value >= 0.0 && bound.value <= bound.most))
      return fail("{}: {} states a {} of {}; it must be 0 to {}", file_.path(), name_, bound.name, bound.value, bound.most);
  }
  if (limits.max_force_n > 0.0 && limits.max_slew_n_per_s <= 0.0)
    return fail("{}: {} states no max_slew_n_per_s; without it no force can begin", file_.path(), name_);
  limits_ = {.max_force_n = limits.max_force_n,
             .max_slew_n_per_s = limits.max_slew_n_per_s,
             .max_stiffness_n_per_m = limits.max_stiffness_n_per_m,
             .workspace_min_m = to_vector(limits.workspace_min_m),
             .workspace_max_m = to_vector(limits.workspace_max_m),
             .max_torque_nm = limits.max_torque_nm,
             .max_torque_slew_nm_per_s = limits.max_torque_slew_nm_per_s,
             .continuous_force_n = limits.continuous_force_n,
             .peak_s = limits.peak_s,
             .max_speed_m_per_s = limits.max_speed_m_per_s};
  const bool is_box = limits_.workspace_min_m.allFinite() && limits_.workspace_max_m.allFinite() &&
                      ((limits_.workspace_max_m - limits_.workspace_min_m).array() > 0.0).all();
  if (!is_box) return fail("{}: {} states no workspace; workspace_min_m must be below workspace_max_m", file_.path(), name_);
  return {};
}

DeviceSample PluginDevice::read(std::int64_t now_ns) noexcept {
  last_.time_ns = now_ns;
  if (status_ == DeviceStatus::fault) return last_;
  hapton_device_sample plugin_sample = {};
  plugin_sample.orientation[0] = 1.0;
  plugin_sample.is_held = 1;
  std::int32_t status = HAPTON_DEVICE_FAULT;
  if (!call_plugin([&] { status = api_.read(device_, now_ns, &plugin_sample); })) status = HAPTON_DEVICE_FAULT;
  status_ = to_status(status);
  if (status_ != DeviceStatus::ready) return last_;
  last_ = {.time_ns = now_ns,
           .p_WD = to_vector(plugin_sample.position_m),
           .q_WT = to_orientation(plugin_sample.orientation),
           .buttons = plugin_sample.buttons,
           .is_held = plugin_sample.is_held != 0};
  return last_;
}

void PluginDevice::write(const Wrench& wrench, std::int64_t now_ns) noexcept {
  if (!call_plugin([&] { api_.write(device_, now_ns, wrench.force_n.data(), wrench.torque_nm.data()); })) status_ = DeviceStatus::fault;
}

Result<std::unique_ptr<Device>> make_plugin_device(const DeviceSettings& settings) {
  const std::string_view name = settings.name;
  if (!name.starts_with(kPluginDevice)) return fail("--device plugin needs a file: --device plugin:FILE.so (docs/plugins.md)");
  const auto choice = parse_plugin_choice(name.substr(kPluginDevice.size()));
  if (!choice) return tl::unexpected(choice.error());
  auto made = PluginDevice::make(*choice);
  if (!made) return tl::unexpected(made.error());
  return std::move(*made);
}

}  // namespace hapton
