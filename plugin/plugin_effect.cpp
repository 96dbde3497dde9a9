#include "plugin/plugin_effect.h"

#include <utility>

namespace hapton {

PluginEffect::PluginEffect(PluginFile file, const hapton_effect_api& api, const Clock& clock, std::int64_t budget_ns)
    : file_(std::move(file)), api_(api), name_(clean_plugin_name(api.name)), guard_(clock, budget_ns, api.max_force_n, api.max_torque_nm) {}

Result<std::unique_ptr<PluginEffect>> PluginEffect::make(const PluginChoice& choice, const Clock& clock, std::int64_t budget_ns) {
  auto file = PluginFile::open(choice);
  if (!file) return tl::unexpected(file.error());
  const auto api = file->find_effect();
  if (!api) return tl::unexpected(api.error());
  std::unique_ptr<PluginEffect> made(new PluginEffect(std::move(*file), **api, clock, budget_ns));
  const PluginRequest request(made->file_.choice());
  if (!call_plugin([&] { made->effect_ = made->api_.create(request.get()); }))
    return fail("{}: {} threw a C++ exception in create", made->file_.path(), made->name_);
  if (made->effect_ == nullptr) return tl::unexpected(request.rejection(made->name_));
  return made;
}

PluginEffect::~PluginEffect() {
  if (effect_ != nullptr && api_.destroy != nullptr) call_plugin([&] { api_.destroy(effect_); });
}

PluginForce PluginEffect::step(const hapton_effect_input& input) noexcept {
  return guard_.step(input.dt_s, [&](PluginForce& plugin_force) {
    // The effect gets its own copy: whatever it writes to it, the next effect gets the measured values.
    const hapton_effect_input input_copy = input;
    hapton_effect_output output = {};
    api_.step(effect_, &input_copy, &output);
    plugin_force.force_n = Vec3(output.force_n[0], output.force_n[1], output.force_n[2]);
    plugin_force.torque_nm = Vec3(output.torque_nm[0], output.torque_nm[1], output.torque_nm[2]);
  });
}

void PluginEffect::reset() noexcept {
  guard_.forget();
  if (guard_.cut_off() || api_.reset == nullptr) return;
  if (!call_plugin([&] { api_.reset(effect_); })) guard_.cut({.reason = CutOff::Reason::exception});
}

}  // namespace hapton
