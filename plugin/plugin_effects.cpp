#include "plugin/plugin_effects.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

void put(const Vec3& from, double (&into)[3]) noexcept {
  for (int k = 0; k < 3; ++k) into[k] = from[k];
}
void put(const Quat& from, double (&into)[4]) noexcept {
  into[0] = from.w();
  into[1] = from.x();
  into[2] = from.y();
  into[3] = from.z();
}

}  // namespace

Result<void> PluginEffects::add(const PluginChoice& choice) {
  if (effects_.size() == kMax) return fail("{}: at most {} effects from files; leave one out", choice.file, kMax);
  auto effect = PluginEffect::make(choice, clock_, budget_ns_);
  if (!effect) return tl::unexpected(effect.error());
  effects_.push_back({.effect = std::move(*effect)});
  return {};
}

hapton_effect_input PluginEffects::make_input(const EffectMoment& moment) noexcept {
  if (std::exchange(is_first_, false)) first_ns_ = moment.time_ns;
  velocity_.add(moment.p_WD, moment.dt_s);
  hapton_effect_input input = {};
  input.sample = moment.sample;
  input.time_s = 1e-9 * static_cast<double>(moment.time_ns - first_ns_);
  input.dt_s = moment.dt_s;
  put(moment.p_WD, input.position_m);
  put(moment.q_WT, input.orientation);
  put(velocity_.mean(), input.velocity_m_per_s);
  put(Vec3(moment.X_WS.translation()), input.scene_position_m);
  put(Quat(moment.X_WS.linear()), input.scene_orientation);
  put(moment.p_WP, input.contact_point_m);
  put(moment.force_n, input.contact_force_n);
  input.buttons = moment.buttons;
  input.contact = moment.contact ? 1 : 0;
  return input;
}

PluginForce PluginEffects::step(const EffectMoment& moment) noexcept {
  const hapton_effect_input input = make_input(moment);
  PluginForce sum;
  for (Entry& entry : effects_) {
    const PluginForce plugin_force = entry.effect->step(input);
    sum.force_n += plugin_force.force_n;
    sum.torque_nm += plugin_force.torque_nm;
  }
  return sum;
}

void PluginEffects::reset() noexcept {
  velocity_.reset();
  is_first_ = true;
  for (Entry& entry : effects_) entry.effect->reset();
}

std::string PluginEffects::to_text() const {
  std::string text;
  for (const Entry& entry : effects_) {
    text += fmt::format("{}{}@{:016x}{}", text.empty() ? " effects=" : ",", entry.effect->name(), entry.effect->file().hash(),
                        entry.effect->guard().cut_off() ? "!cut" : "");
  }
  return text;
}

bool PluginEffects::has_notices() const noexcept {
  return std::ranges::any_of(effects_, [](const Entry& entry) { return entry.effect->guard().cut_off() && !entry.is_reported; });
}

std::vector<std::string> PluginEffects::take_notices() {
  std::vector<std::string> notices;
  for (Entry& entry : effects_) {
    const CutOff& cut_off = entry.effect->guard().cut_off();
    if (!cut_off || std::exchange(entry.is_reported, true)) continue;
    notices.push_back(fmt::format("effect {} ({}) is cut off: {}; its force fades, the others go on. Start haptics_node again to use it",
                                  entry.effect->name(), entry.effect->file().path(), hapton::describe(cut_off)));
  }
  return notices;
}

std::string PluginEffects::describe() const {
  std::string text;
  for (const Entry& entry : effects_) {
    text += fmt::format("effect {} ({}): {}", entry.effect->name(), entry.effect->file().choice().to_text(),
                        describe_calls(entry.effect->guard()));
  }
  return text;
}

}  // namespace hapton
