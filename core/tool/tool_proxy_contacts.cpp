// The contacts that a tool has or may soon have: the fast task computes with them until the next step of the proxy.
#include <algorithm>

#include "core/tool/contact_choice.h"
#include "core/tool/tool_proxy.h"

namespace hapton {

void ToolProxy::find_local_contacts(const Placement& device, std::span<const Placement> parts, double reach,
                                    LocalContacts& local) noexcept {
  local.count = 0;
  local.is_blocked = is_blocked_;
  local.proxy = proxy_;
  local.inverse_root = energy_.inverse_root();
  local.plain_inverse_root << Vec3::Ones(), Vec3::Constant(1.0 / energy_.turn_length());
  local.stiffness << Vec3::Ones(), Vec3::Constant(energy_.turn_length() * energy_.turn_length());
  local.tolerance = kTolerance;
  local.is_held = false;
  if (is_blocked_) return;
  if (local_reach_limit_ > 0.0) reach = std::min(reach, local_reach_limit_);
  while (!collect(proxy_, reach + kContactOffset, std::min(2.0 * reach / radius(), kLargestTilt))) {
    reach *= kShrinkage;
    local_reach_limit_ = reach;
    local.is_held = reach < kContactOffset;
    if (local.is_held) return;
  }
  last_local_reach_ = reach;
  limit_local_reach();
  find_minima();
  if (bound_count_ <= LocalContacts::kMax) {
    for (std::size_t i = 0; i < bound_count_; ++i) local.add(bounds_[i], local_contact(bound_pairs_[i]));
    return;
  }
  choose_local_contacts(device, parts, reach, local);
}

// Sets the limit of the reach of the next search. Pairs within the smallest reach raise the number allowed: no limit leaves them out.
void ToolProxy::limit_local_reach() noexcept {
  constexpr double kMany = 512.0;  // pairs; each takes about 2 us
  double all = 0.0;
  double close = 0.0;
  for (const auto& part : parts_) {
    for (const NearFeature& near : part->near().features()) {
      all += 1.0;
      close += near.gap.distance <= kMinLocalReach + kContactOffset ? 1.0 : 0.0;
    }
  }
  const double most = kMany + 2.0 * close;
  if (all > most) {
    local_reach_limit_ = std::max(kMinLocalReach, std::max(kShrinkage, 0.5 * most / all) * last_local_reach_);
  } else if (all < 0.25 * most && local_reach_limit_ > 0.0) {
    local_reach_limit_ *= 2.0;
    if (local_reach_limit_ > radius()) local_reach_limit_ = 0.0;
  }
}

// Writes a bound of shift and turn for each local minimum of the distance among the features that collect() has found.
void ToolProxy::find_minima() noexcept {
  bound_count_ = 0;
  for (std::uint32_t p = 0; p < parts_.size(); ++p) {
    const auto features = parts_[p]->near().features();
    for (std::uint32_t f = 0; f < features.size(); ++f) {
      if (!features[f].is_minimum) continue;
      bounds_[bound_count_] = local_bound({p, f});
      bound_pairs_[bound_count_++] = {p, f};
    }
  }
}

MotionBound ToolProxy::local_bound(const BoundPair& pair) const noexcept {
  const ScenePart& part = *parts_[pair.part];
  const NearFeature& near = near_of(pair);
  MotionBound bound{.least = kContactOffset - near.gap.distance};
  bound.row << part.direction(near.gap.normal), part.direction(near.gap.on_tool.cross(near.gap.normal));
  return bound;
}

LocalContact ToolProxy::local_contact(const BoundPair& pair) const noexcept {
  const ScenePart& part = *parts_[pair.part];
  const NearFeature& near = near_of(pair);
  const std::uint32_t object = part.near().object_of(near.pair);
  LocalContact contact{.arm = part.direction(near.gap.on_tool), .friction = part.friction_of(object), .object = object};
  if (part.moves()) {
    contact.part = static_cast<int>(pair.part);
    contact.point = part.point(near.gap.on_scene);
    contact.anchor = part.target().inverse().at(contact.point);
    contact.found_least = kContactOffset - near.gap.distance;
  }
  return contact;
}

// If there are more contacts than fit, chooses those that hold the tool at the given poses of device and parts, and those that hold it if
// the device then shifts by `reach` along an axis, or turns as far about an axis.
void ToolProxy::choose_local_contacts(const Placement& device, std::span<const Placement> parts, double reach,
                                      LocalContacts& local) noexcept {
  std::array<Vec6, 13> goals;
  goals[0] = motion_between(proxy_, device).shift_and_turn();
  for (std::size_t g = 1; g < goals.size(); ++g) {
    const auto axis = static_cast<int>(g - 1) / 2;
    const double length = axis < 3 ? reach : reach / radius();
    goals[g] = goals[0];
    goals[g][axis] += g % 2 == 1 ? length : -length;
  }
  for (std::size_t i = 0; i < bound_count_ && !parts.empty(); ++i) {
    if (parts_[bound_pairs_[i].part]->moves()) bounds_[i].least = moved_least(bounds_[i], local_contact(bound_pairs_[i]), parts);
  }
  std::array<std::uint32_t, LocalContacts::kMax> chosen;
  const std::size_t count = choose_contacts({bounds_.data(), bound_count_}, goals, local, chosen);
  for (std::size_t i = 0; i < count; ++i) {
    const BoundPair& pair = bound_pairs_[chosen[i]];
    local.add(local_bound(pair), local_contact(pair));
  }
}

}  // namespace hapton
