#include "core/tool/held_tool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace hapton {
namespace {

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

// Without friction.
std::size_t list_forces(const LocalContacts& contacts, const LocalContacts::Solution& solution,
                        std::span<ContactForce, ContactCones::kMax> forces) {
  const auto count = static_cast<std::size_t>(solution.active_count);
  for (std::size_t k = 0; k < count; ++k) {
    const double multiplier = solution.multipliers[static_cast<Eigen::Index>(k)];
    forces[k] = {solution.active[k], multiplier * contacts.bounds[static_cast<std::size_t>(solution.active[k])].row, multiplier};
  }
  return count;
}

}  // namespace

HeldTool::HeldTool(std::unique_ptr<ToolStep> tool)
    : tool_(std::move(tool)),
      samples_(Sample{.parts = std::vector<Placement>(tool_->moving_count())}),
      damping_(tool_->damping()),
      has_friction_(tool_->has_friction()),
      parts_(tool_->moving_count()),
      last_parts_(parts_),
      pushes_(parts_.size()) {
  last_sample_.parts = parts_;
  place_objects();
}

void HeldTool::place_objects() {
  friction_of_.resize(parts_.size() + 1);
  friction_of_[0].resize(tool_->scene().object_count());
  for (std::size_t p = 0; p < parts_.size(); ++p) friction_of_[p + 1].resize(tool_->moving(p).object_count());
  counts_.resize(friction_of_.size());
  for (const auto& objects : friction_of_) damping_of_.emplace_back(objects.size());
}

void HeldTool::set_materials(const ToolMaterials& materials) noexcept {
  tool_->set_stiffness(materials.stiffness_n_per_m);
  has_changed_ = true;
  has_friction_ = false;
  // The objects of a part are numbered in the order of the scene.
  std::fill(counts_.begin(), counts_.end(), std::size_t{0});
  for (std::size_t o = 0; o < std::min(materials.friction.size(), materials.damping.size()); ++o) {
    const std::size_t part = tool_->part_of(o);
    const std::size_t object = counts_[part]++;
    if (object >= friction_of_[part].size()) continue;
    friction_of_[part][object] = materials.friction[o];
    damping_of_[part][object] = materials.damping[o];
    has_friction_ = has_friction_ || materials.friction[o].friction_static > 0.0;
  }
  if (!has_friction_) friction_.forget();
  damping_.set_damping(damping_of_);
}

void HeldTool::set_friction(LocalContacts& contacts) const noexcept {
  for (std::size_t i = 0; i < contacts.count; ++i) {
    LocalContact& contact = contacts.contacts[i];
    contact.friction = friction_of_[static_cast<std::size_t>(contact.part)][contact.object];
  }
}

HeldTool::HeldTool(std::unique_ptr<ToolStep> tool, const Pose& X_SP) : HeldTool(std::move(tool)) {
  start_ = tool_->to_local({.X_WD = X_SP});
}

void HeldTool::publish(const Placement& device, const Placement& goal, std::int64_t time_ns) noexcept {
  Sample& sample = samples_.draft();
  sample.device = device;
  sample.goal = goal;
  sample.time_ns = time_ns;
  sample.serial = serial_;
  std::copy(parts_.begin(), parts_.end(), sample.parts.begin());
  samples_.publish_draft();
}

// Takes the newest contacts of the slow task. True: they are new, and have come late.
bool HeldTool::take_found_contacts(std::int64_t time_ns) noexcept {
  ++samples_since_new_;
  const bool are_new = found_contacts_.take();
  if (seconds(time_ns - last_step_ns_) > kLongestGapS) is_after_sample_gap_ = true;
  is_after_sample_gap_ = is_after_sample_gap_ && !are_new;
  const bool are_late = are_new && samples_since_new_ > kMaxPromptSamples;
  if (are_new) samples_since_new_ = 0;
  return are_late;
}

// While more pairs are near than can be considered, the proxy stays, whatever the device does. After kStaleS of that, begins anew.
void HeldTool::note_frozen(const FoundContacts& found, std::int64_t time_ns) noexcept {
  if (is_known_ && found.contacts.is_held) {
    frozen_s_ += std::clamp(seconds(time_ns - last_step_ns_), 0.0, kLongestGapS);
  } else {
    frozen_s_ = 0.0;
  }
  if (frozen_s_ < kStaleS) return;
  begin_anew();
  frozen_s_ = 0.0;
  is_known_ = false;
}

void HeldTool::count_lateness() noexcept {
  ++lateness_.samples;
  lateness_.faded += age_s_ > kFreshS ? 1 : 0;
  lateness_.longest_s = std::max(lateness_.longest_s, age_s_);
}

// No contacts are known, or the proxy is blocked, so nothing is felt.
void HeldTool::release(const Placement& device, std::int64_t time_ns) noexcept {
  damping_.release();
  publish(device, device, time_ns);
  friction_.forget();
  last_wrench_ = {};
  fading_share_ = 0.0;
  last_device_ = device;
  last_step_ns_ = time_ns;
}

ToolOutput HeldTool::step(const ToolInput& input, std::int64_t time_ns) noexcept {
  ToolOutput output;
  output.X_WP = input.X_WD;
  std::fill(pushes_.begin(), pushes_.end(), ToolPush());
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return output;
  const Placement device = tool_->to_local(input);
  std::copy(parts_.begin(), parts_.end(), last_parts_.begin());
  tool_->to_local(input.X_SO, parts_);
  const bool are_late = take_found_contacts(time_ns);
  FoundContacts& found = found_contacts_.value();
  output.proxy = found.step;
  is_known_ = found.serial == serial_;
  note_frozen(found, time_ns);
  output.proxy.is_blocked = is_known_ && found.contacts.is_blocked;
  age_s_ = is_known_ ? std::max(0.0, seconds(time_ns - found.time_ns)) : 0.0;
  if (damping_.is_on()) move_damping(input, device, seconds(time_ns - last_step_ns_));
  if (!is_known_ || output.proxy.is_blocked) {
    release(device, time_ns);
    return output;
  }
  const ToolProxyStep step = output.proxy;
  if (!is_after_sample_gap_) count_lateness();
  Placement goal = device;
  Placement at = device;
  found.contacts.follow(parts_);
  if (has_changed_) set_friction(found.contacts);
  LocalContacts::Solution solution;
  if (has_friction_) {
    const ToolFriction::Step friction_step = friction_.step(found.contacts, device, parts_);
    goal = friction_step.goal;
    solution = friction_step.solution;
    at = friction_step.at;
  } else {
    solution = found.contacts.solve(device);
    at = solution.at;
  }
  output = tool_->felt_at(input, device, at);
  const Vec3 felt_p_WP = output.X_WP.translation();
  if (age_s_ > kLateS) output.X_WP = tool_->felt_at(input, device, drawn_pose(found, at)).X_WP;
  find_pushes(found.contacts, solution, output, input.X_WS.linear());
  publish(device, goal, time_ns);
  output.proxy = step;
  const double share = std::clamp((kStaleS - std::max(age_s_, frozen_s_)) / (kStaleS - kFreshS), 0.0, 1.0);
  output.force_n *= share;
  output.torque_nm *= share * torque_share(turn_between(device.orientation, at.orientation));
  // The parts get the whole torque of the contacts, also where the stylus feels only a share of it (torque_share).
  for (ToolPush& push : pushes_) push = {share * push.force_n, share * push.torque_nm};
  blend(output, device, time_ns, are_late);
  if (damping_.is_on()) add_damping(found.contacts, solution, share, input.X_WS.linear(), output);
  const Vec3 shift_m = felt_p_WP - output.X_WP.translation();
  for (ToolPush& push : pushes_) push.torque_nm += shift_m.cross(push.force_n);
  return output;
}

Placement HeldTool::drawn_pose(const FoundContacts& found, const Placement& at) const noexcept {
  // Moving parts push the tool ahead, however far: found.reach limits only its motion from there.
  const Placement from = parts_.empty() ? found.contacts.proxy : found.contacts.constrain(found.contacts.proxy);
  const RigidMotion motion = motion_between(from, at);
  const double length = motion.length(tool_->proxy().radius());
  if (length <= found.reach) return at;
  const double lateness_share = std::min(1.0, (age_s_ - kLateS) / kLateS);
  return motion.at(1.0 + lateness_share * (found.reach / length - 1.0));
}

void HeldTool::find_pushes(const LocalContacts& contacts, const LocalContacts::Solution& solution, const ToolOutput& felt,
                           const Mat3& R_WS) noexcept {
  if (pushes_.empty() || solution.active_count == 0) return;
  std::array<ContactForce, ContactCones::kMax> all;
  const std::size_t count = has_friction_ ? friction_.list_forces(contacts, all) : list_forces(contacts, solution, all);
  const std::span<const ContactForce> forces(all.data(), count);
  // What a multiplier of 1 means: this force, and the torque of this force at a lever of one local unit.
  const double unit_n = tool_->unit_force_n();
  const double unit_nm = unit_n * tool_->scene().unit_m();
  Vec3 remaining_n = felt.force_n;
  Vec3 remaining_nm = felt.torque_nm;
  double normal_sum = 0.0;
  const auto oppose = [&](const ContactForce& contact, const Vec3& force_n, const Vec3& torque_nm) {
    const int part = contacts.contacts[static_cast<std::size_t>(contact.index)].part;
    if (part <= 0) return;
    ToolPush& push = pushes_[static_cast<std::size_t>(part) - 1];
    push = {push.force_n - force_n, push.torque_nm - torque_nm};
  };
  for (const ContactForce& contact : forces) {
    const Vec3 force_n = unit_n * (R_WS * contact.wrench.head<3>());
    const Vec3 torque_nm = unit_nm * (R_WS * contact.wrench.tail<3>());
    remaining_n -= force_n;
    remaining_nm -= torque_nm;
    normal_sum += contact.normal;
    oppose(contact, force_n, torque_nm);
  }
  if (!has_friction_ || !(normal_sum > 0.0)) return;
  for (const ContactForce& contact : forces) {
    const double share = contact.normal / normal_sum;
    oppose(contact, share * remaining_n, share * remaining_nm);
  }
}

void HeldTool::move_damping(const ToolInput& input, const Placement& device, double dt_s) noexcept {
  if (!is_known_ || dt_s < 0.0 || dt_s > kLongestGapS) damping_.reset();
  tool_->note_view(input, last_view_, damping_);
  damping_.move(device, parts_, dt_s);
}

void HeldTool::add_damping(const LocalContacts& contacts, const LocalContacts::Solution& solution, double share, const Mat3& R_WS,
                           ToolOutput& output) noexcept {
  std::array<ContactDamping::Contact, ContactDamping::kMaxContacts> touched;
  const std::size_t count = list_damping_contacts(contacts, solution, share * tool_->unit_force_n(), touched);
  const ContactDamping::Wrench damping = damping_.step({touched.data(), count}, output.contact);
  output.force_n += R_WS * damping.force_n;
  output.torque_nm += R_WS * damping.torque_nm;
  for (std::size_t p = 0; p < pushes_.size(); ++p) {
    const ContactDamping::Wrench part = damping_.wrench_of_part(static_cast<int>(p) + 1);
    pushes_[p] = {pushes_[p].force_n - R_WS * part.force_n, pushes_[p].torque_nm - R_WS * part.torque_nm};
  }
}

// How far the device is from the proxy, in the energy norm of the coupling, local units.
double HeldTool::coupling_extension(const ContactDamping::Wrench& felt) const noexcept {
  const ToolCoupling& coupling = tool_->coupling();
  const double k = coupling.stiffness_n_per_m;
  return std::sqrt(felt.force_n.squaredNorm() / (k * k) + felt.torque_nm.squaredNorm() / (k * coupling.rotational_stiffness_nm_per_rad)) /
         tool_->scene().unit_m();
}

// While the contacts stay the same, the distance from device to proxy changes by no more than the device moves: so does the distance of any
// point from a convex set. Twice that leaves room for the contacts' curvature; a force that jumps by more is changed gradually.
void HeldTool::blend(ToolOutput& output, const Placement& device, std::int64_t time_ns, bool are_late) noexcept {
  fading_share_ = std::max(0.0, fading_share_ - std::clamp(seconds(time_ns - last_step_ns_), 0.0, kMaxFadeStepS) / kContactFadeS);
  const ContactDamping::Wrench plain{output.force_n, output.torque_nm};
  if (are_late) {
    const ContactDamping::Wrench jump{last_wrench_.force_n - plain.force_n - fading_share_ * fading_wrench_.force_n,
                                      last_wrench_.torque_nm - plain.torque_nm - fading_share_ * fading_wrench_.torque_nm};
    const ToolCoupling& coupling = tool_->coupling();
    const Vec3 turn = turn_between(last_device_.orientation, device.orientation);
    const double lever_squared = coupling.rotational_stiffness_nm_per_rad / coupling.stiffness_n_per_m;
    double moved = std::sqrt((device.position - last_device_.position).squaredNorm() +
                             turn.squaredNorm() * lever_squared / (tool_->scene().unit_m() * tool_->scene().unit_m()));
    for (std::size_t p = 0; p < parts_.size(); ++p)
      moved += relative_travel_bound(device, tool_->proxy().radius(), last_parts_[p], parts_[p]);
    if (coupling_extension(jump) > 2.0 * moved + ToolProxy::kContactOffset) {
      fading_wrench_ = {last_wrench_.force_n - plain.force_n, last_wrench_.torque_nm - plain.torque_nm};
      fading_share_ = 1.0;
    }
  }
  if (fading_share_ > 0.0) {
    output.force_n += fading_share_ * fading_wrench_.force_n;
    output.torque_nm += fading_share_ * fading_wrench_.torque_nm;
  }
  last_wrench_ = {output.force_n, output.torque_nm};
  last_device_ = device;
  last_step_ns_ = time_ns;
}

double HeldTool::travel_since_last(const Sample& sample) const noexcept {
  const ToolProxy& proxy = tool_->proxy();
  return motion_between(last_sample_.device, sample.device).length(proxy.radius()) + proxy.travel();
}

bool HeldTool::follow() noexcept {
  if (!samples_.take()) return false;
  const Sample& sample = samples_.value();
  FoundContacts& found = found_contacts_.draft();
  ToolProxy& proxy = tool_->proxy();
  const bool is_first = sample.serial != last_sample_.serial;
  if (is_first) proxy.reset(start_.value_or(sample.device), sample.parts);
  start_.reset();
  found.step = proxy.step(sample.goal, sample.parts);
  // The reach covers the motion of device and parts of the scene until the next contacts come, if their speed stays the same.
  const double reach = proxy.local_reach(is_first ? 0.0 : travel_since_last(sample));
  proxy.find_local_contacts(sample.device, sample.parts, reach, found.contacts);
  found.contacts.is_held = found.contacts.is_held || found.step.is_frozen;
  found.reach = proxy.last_local_reach();
  found.time_ns = sample.time_ns;
  found.serial = sample.serial;
  last_sample_ = sample;
  found_contacts_.publish_draft();
  return true;
}

}  // namespace hapton
