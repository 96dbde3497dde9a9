#include "patch/patch_touch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/motion_groups.h"
#include "core/math/rigid_pose.h"

namespace hapton {

namespace {

constexpr double kNanosecond = 1e-9;    // s, by which a stage may begin before the end of the last one: rounding
constexpr double kTimeRounding = 1e-6;  // share of a stage's duration: its two shapes are rounded to the grid of the parts

}  // namespace

std::unique_ptr<Patch> PatchTouch::offer(std::unique_ptr<Patch> patch) noexcept { return std::exchange(offered_, std::move(patch)); }

std::unique_ptr<Patch> PatchTouch::take_retired() noexcept { return std::move(retired_); }

void PatchTouch::forget() noexcept {
  is_placed_ = has_taken_over_ = is_on_grid_ = has_arrived_ = is_beyond_ = false;
  outward_S_.setZero();
  path_.clear();
}

void PatchTouch::set_generation(std::uint32_t generation) noexcept {
  // The hand has not moved: the next patch takes over from where the probe was.
  if (std::exchange(generation_, generation) != generation) has_taken_over_ = is_on_grid_ = has_arrived_ = false;
}

void PatchTouch::start_at(const Vec3& p_SP, const Vec3& outward, double age_s) noexcept {
  is_placed_ = p_SP.allFinite() && outward.allFinite();
  has_taken_over_ = is_on_grid_ = has_arrived_ = false;
  p_SP_ = last_p_SD_ = p_SP;
  outward_S_ = outward;
  path_.keep_newest(age_s);
  stiffness_n_per_m_ = force_n_ = beyond_time_s_ = 0.0;
}

void PatchTouch::go_on_from(const Vec3& p_SP) noexcept {
  path_.clear();
  is_placed_ = is_on_grid_ = true;
  has_taken_over_ = is_beyond_ = false;
  p_SP_ = last_p_SD_ = newest_p_SD_ = p_SP;
  outward_S_.setZero();
  stiffness_n_per_m_ = force_n_ = beyond_time_s_ = 0.0;
}

// Sets the materials of those objects that the patch has; both are in the order of the scene. True: at least one was set.
bool PatchTouch::tune(Patch& patch, const PatchMaterials& materials) noexcept {
  if (patch.step == nullptr || patch.material_version >= materials.version) return false;
  patch.material_version = materials.version;
  bool is_tuned = false;
  for (std::size_t i = 0; i < std::min(patch.objects.size(), patch.materials.size()); ++i) {
    const auto found = std::lower_bound(materials.objects.begin(), materials.objects.end(), patch.objects[i],
                                        [](const auto& one, int object) { return one.first < object; });
    if (found == materials.objects.end() || found->first != patch.objects[i]) continue;
    Material tuned = found->second;
    tuned.two_sided = patch.materials[i].two_sided;
    patch.materials[i] = tuned;
    if (i < patch.shared.size()) patch.shared[i] = shared_material(tuned);
    is_tuned = true;
  }
  if (is_tuned) patch.set_materials();
  return is_tuned;
}

void PatchTouch::set_shared(bool is_shared) noexcept {
  is_shared_ = is_shared;
  if (patch_ != nullptr) update_shared(*patch_);
}

void PatchTouch::update_shared(Patch& patch) noexcept {
  if (patch.step != nullptr && std::exchange(patch.is_shared, is_shared_) != is_shared_) patch.set_materials();
}

void PatchTouch::use_materials(const PatchMaterials& materials) noexcept {
  if (offered_ != nullptr) (void)tune(*offered_, materials);
  if (patch_ != nullptr && tune(*patch_, materials)) is_retuned_ = true;
}

PatchHandState PatchTouch::hand_at(const Vec3& p_SD, std::int64_t time_ns) const noexcept {
  return {p_SD, time_ns, is_beyond_, is_beyond_ ? path_ball() : PathBall()};
}

PathBall PatchTouch::path_ball() const noexcept {
  Vec3 low = p_SP_;
  Vec3 high = p_SP_;
  for (std::size_t i = 0; i < path_.size(); ++i) {
    low = low.cwiseMin(path_[i].p_SD);
    high = high.cwiseMax(path_[i].p_SD);
  }
  return {0.5 * (low + high), 0.5 * (high - low).norm()};
}

// A patch in use has followed the device to last_p_SD_ in its last step, with the proxy at p_SP_. In a patch that has not taken over yet,
// the first step begins with the device at the proxy.
bool PatchTouch::reaches(const Patch& patch, const Vec3& p_SD) const noexcept {
  if (patch.generation != generation_) return false;
  if (std::isinf(patch.radius_m)) return true;
  const double from_centre_m = (p_SD - patch.p_SC).norm();
  const bool goes_on = has_taken_over_ && &patch == patch_.get();
  const double travel_m = goes_on ? (p_SP_ - last_p_SD_).norm() + (p_SD - last_p_SD_).norm() : (p_SD - p_SP_).norm() + 2.0 * patch.lift_m;
  return from_centre_m + travel_m < patch.radius_m;
}

// False: the coordinates of the device point are so large that their rounding exceeds lift_m, so the proxy could not be distinguished from
// the surface. A patch of an earlier generation sets no limit, because its scene is over.
bool PatchTouch::is_precise_enough(const Vec3& p_SD) const noexcept {
  constexpr double kRounding = 0x1p-52;  // of a coordinate
  const bool is_unlimited = patch_ == nullptr || patch_->generation != generation_;
  return p_SD.allFinite() && (is_unlimited || p_SD.cwiseAbs().maxCoeff() * kRounding <= patch_->lift_m);
}

std::optional<PatchOutput> PatchTouch::step(const TouchInput& input) noexcept {
  const Vec3 p_SD = to_frame(input.X_WS, input.p_WD);
  if (!is_precise_enough(p_SD)) return std::nullopt;
  if (input.is_correction && is_placed_) return correct(input, p_SD);
  // If the hand enters a surface before the surface's tiles have come, the surface holds the hand once they have come.
  if (!is_placed_) {
    start_at(p_SD, Vec3::Zero());
    newest_p_SD_ = p_SD;
  }
  previous_p_SD_ = std::exchange(newest_p_SD_, p_SD);
  const Vec3 velocity = (p_SD - previous_p_SD_) / input.dt_s;
  path_.push({p_SD, input.dt_s, input.time_s});
  const bool was_beyond = is_beyond_;
  bool could_go_on = !was_beyond && has_taken_over_ && reaches_next();
  take_offered({p_SD, input.dt_s, input.time_s});
  PatchOutput output;
  for (int n = 0; n < kMaxFollowed && reaches_next(); ++n) {
    const DevicePath::Place place = path_.front();
    path_.pop();
    counts_.followed += path_.empty() ? 0 : 1;
    output = step_patch({.p_WD = input.X_WS * place.p_SD, .X_WS = input.X_WS, .dt_s = place.dt_s, .time_s = place.time_s}, place.p_SD,
                        std::exchange(could_go_on, false));
  }
  if (!path_.empty()) return step_plane(input, p_SD, velocity);
  is_beyond_ = false;
  has_arrived_ = true;
  output.is_handed_over = output.is_handed_over || was_beyond || std::exchange(is_retuned_, false);
  return output;
}

bool PatchTouch::take(PatchShape& shape) noexcept {
  Patch* patch = nullptr;
  std::uint32_t newest_number = 0;
  for (Patch* const one : {patch_.get(), offered_.get()}) {
    if (one == nullptr || one->streamed == nullptr) continue;
    newest_number = std::max(newest_number, one->number);
    if (one->number == shape.patch) patch = one;
  }
  if (patch == nullptr) return shape.patch < newest_number;
  StreamedMethod& method = *patch->streamed;
  if (method.waiting() == StreamedMethod::kMaxWaiting) return false;
  ++counts_.shapes;
  const double start_s = 1e-9 * static_cast<double>(shape.start_ns);
  const double duration_s = 1e-9 * static_cast<double>(shape.end_ns - shape.start_ns);
  const double min_duration_s = StreamedMethod::compute_time_s(*shape.stage, 0.0);
  const double earliest_s = std::max(method.end_s(), method.last_time_s());
  const bool is_in_time = start_s >= method.last_time_s() && start_s + kNanosecond >= method.end_s();
  if (is_in_time && duration_s * (1.0 + kTimeRounding) >= min_duration_s) {
    shape.stage = method.offer_at(std::move(shape.stage), start_s, duration_s);
    return true;
  }
  ++counts_.late_shapes;
  const double late_start_s = std::max(start_s, earliest_s);
  shape.stage = method.offer_at(std::move(shape.stage), late_start_s,
                                std::max(min_duration_s, 1e-9 * static_cast<double>(shape.end_ns) - late_start_s));
  return true;
}

StiffnessRange PatchTouch::stiffness() const noexcept {
  if (is_beyond_ || patch_ == nullptr || patch_->materials.empty()) return {stiffness_n_per_m_, stiffness_n_per_m_};
  const auto [least, most] = std::ranges::minmax_element(patch_->materials, {}, &Material::stiffness_n_per_m);
  return {least->stiffness_n_per_m, most->stiffness_n_per_m};
}

bool PatchTouch::is_frictionless() const noexcept {
  if (is_beyond_ || patch_ == nullptr) return false;
  return std::ranges::all_of(patch_->materials, [](const Material& material) { return material.friction_dynamic == 0.0; });
}

// Null: the patch does not have the object.
const Material* PatchTouch::find_material(int object) const noexcept {
  if (is_beyond_ || patch_ == nullptr) return nullptr;
  const auto found = std::lower_bound(patch_->objects.begin(), patch_->objects.end(), object);
  const auto n = static_cast<std::size_t>(found - patch_->objects.begin());
  return found == patch_->objects.end() || *found != object || n >= patch_->materials.size() ? nullptr : &patch_->materials[n];
}

double PatchTouch::damping_of(int object) const noexcept {
  const Material* const material = find_material(object);
  return material != nullptr ? material->damping_ns_per_m : 0.0;
}

double PatchTouch::stiffness_of(int object) const noexcept {
  const Material* const material = find_material(object);
  return material != nullptr ? material->stiffness_n_per_m : stiffness().most;
}

std::optional<SurfacePlace> PatchTouch::find_place(int object) const noexcept {
  if (is_beyond_ || patch_ == nullptr || patch_->step == nullptr) return std::nullopt;
  const auto found = std::find(patch_->objects.begin(), patch_->objects.end(), object);
  if (found == patch_->objects.end()) return std::nullopt;
  return patch_->step->method().find_place(static_cast<int>(found - patch_->objects.begin()));
}

// Computes the last sample again with a corrected device point; no patch takes over in it.
std::optional<PatchOutput> PatchTouch::correct(const TouchInput& input, const Vec3& p_SD) noexcept {
  newest_p_SD_ = p_SD;
  if (path_.empty() && patch_ != nullptr && reaches(*patch_, p_SD)) return step_patch(input, p_SD, false);
  if (path_.empty()) {
    path_.push({p_SD, input.dt_s, input.time_s});
  } else {
    path_.replace_newest(p_SD);
  }
  return step_plane(input, p_SD, (p_SD - previous_p_SD_) / input.dt_s);
}

void PatchTouch::take_offered(const DevicePath::Place& newest) noexcept {
  if (offered_ == nullptr || retired_ != nullptr) return;
  if (!reaches(*offered_, path_.front().p_SD)) {
    if (!is_beyond_ || !offered_->is_path_incomplete || !rise_over(*offered_, newest.p_SD)) return;
    path_.clear();
    path_.push(newest);
  }
  retired_ = std::exchange(patch_, std::move(offered_));
  update_shared(*patch_);
  has_taken_over_ = false;
}

// The last proxy within the old patch is out of this patch's reach. The plane has brought the hand here: the proxy starts where the plane
// holds it, and somewhat farther out because the surface may have risen on the way, as far as this patch knows what is there.
bool PatchTouch::rise_over(const Patch& patch, const Vec3& p_SD) noexcept {
  if (patch.generation != generation_ || outward_S_.isZero(0.0)) return false;
  const double depth_m = std::max((p_SP_ - p_SD).dot(outward_S_), 0.0);
  const double along_m = (p_SD + depth_m * outward_S_ - p_SP_).norm();
  const double room_m = patch.radius_m - (p_SD - patch.p_SC).norm() - 4.0 * patch.lift_m;
  const double desired_rise_m = depth_m + kRisePerDistance * along_m;
  const double rise_m = std::min(desired_rise_m, kMaxRoomShare * room_m);
  // A start below the surface would be a fall-through: a patch that is too small for the rise has to grow first.
  const double min_rise_m = std::min(desired_rise_m, kMinRiseInDepths * force_n_ / stiffness_n_per_m_);
  if (!(rise_m > 0.0 && rise_m >= min_rise_m)) return false;
  p_SP_ = p_SD + rise_m * outward_S_;
  is_on_grid_ = false;
  ++counts_.raised;
  return true;
}

void PatchTouch::hand_over(const TouchInput& input) noexcept {
  has_taken_over_ = true;
  // A correction begins the sample again on the same patch.
  counts_.handed_over += input.is_correction ? 0 : 1;
  if (patch_->step == nullptr) return;
  TouchInput start = input;
  start.p_WD = input.X_WS * (is_on_grid_ ? p_SP_ : Vec3(p_SP_ + patch_->lift_m * outward_S_));
  if (is_on_grid_) {
    patch_->step->resume(start);
  } else {
    patch_->step->reset(start);
  }
  // If a surface deforms, the proxy was here on the shape that the surface had before this sample: begins with that shape.
  if (patch_->deforms) {
    start.time_s -= input.dt_s;
    start.is_correction = false;
    (void)patch_->step->step(start);
  }
  // The hand did not move from the start to the device point: this step keeps damping from seeing that motion.
  (void)patch_->step->step(input);
}

Vec3 PatchTouch::step_retired(const TouchInput& input) noexcept {
  return retired_->step != nullptr ? retired_->step->step(input).force_n : Vec3(Vec3::Zero());
}

std::optional<Vec3> PatchTouch::carried_from() const noexcept {
  return has_taken_over_ && patch_ != nullptr && patch_->step != nullptr ? patch_->step->method().carried_from() : std::nullopt;
}

// The plane past the edge has damping of its own, so the surface's damping, which may have taken all of the force or added to it, is left
// out. Between several objects the stiffness is a mean (ProxyMethod): the force felt, within what the softest and the stiffest give.
double PatchTouch::undamped_force_n(const TouchOutput& touch_output, double depth) const noexcept {
  const auto object = static_cast<std::size_t>(touch_output.object);
  const bool is_known = touch_output.contact && touch_output.object >= 0 && object < patch_->materials.size();
  if (!is_known || patch_->materials[object].damping_ns_per_m == 0.0) return touch_output.force_n.norm();
  const auto [least, most] = std::ranges::minmax_element(patch_->materials, {}, &Material::stiffness_n_per_m);
  return std::clamp(touch_output.force_n.norm(), least->stiffness_n_per_m * depth, most->stiffness_n_per_m * depth);
}

// could_go_on: the patch before this step held the proxy and reaches this sample, so if another takes over, the force of both is known.
PatchOutput PatchTouch::step_patch(const TouchInput& input, const Vec3& p_SD, bool could_go_on) noexcept {
  PatchOutput output;
  const bool begins = !has_taken_over_;
  const bool has_before = begins && could_go_on;
  const Vec3 force_before_n = has_before ? step_retired(input) : Vec3(Vec3::Zero());
  if (begins) hand_over(input);
  const TouchOutput touch_output = patch_->step != nullptr ? patch_->step->step(input) : TouchOutput();
  output.is_handed_over = begins && !has_before;
  if (has_before) output.difference_n = force_before_n - touch_output.force_n;
  output.force_n = touch_output.force_n;
  output.visual_offset_m = touch_output.visual_offset_m;
  output.contact = touch_output.contact;
  if (touch_output.object >= 0 && touch_output.object < static_cast<int>(patch_->objects.size()))
    output.object = patch_->objects[static_cast<std::size_t>(touch_output.object)];
  const Mat3 R_SW = input.X_WS.linear().transpose();
  const double depth = touch_output.visual_offset_m.norm();
  force_n_ = undamped_force_n(touch_output, depth);
  p_SP_ = (patch_->step != nullptr ? patch_->step->method().held_at() : std::nullopt).value_or(p_SD);
  outward_S_ = touch_output.contact && depth > 0.0 ? Vec3(R_SW * touch_output.visual_offset_m / depth) : Vec3(Vec3::Zero());
  stiffness_n_per_m_ = depth > 0.0 ? force_n_ / depth : 0.0;
  last_p_SD_ = carried_from().value_or(p_SD);
  is_placed_ = is_on_grid_ = true;
  if (input.is_correction) return output;
  ++counts_.steps;
  counts_.contact_steps += touch_output.contact ? 1 : 0;
  return output;
}

std::optional<PatchOutput> PatchTouch::step_plane(const TouchInput& input, const Vec3& p_SD, const Vec3& velocity) noexcept {
  PatchOutput output;
  output.is_beyond = true;
  output.is_handed_over = !is_beyond_;
  const bool has_patch = has_arrived_ && patch_ != nullptr && patch_->generation == generation_;
  if (!std::exchange(is_beyond_, true)) {
    counts_.beyond += has_patch ? 1 : 0;
    beyond_time_s_ = 0.0;
  }
  if (!input.is_correction) beyond_time_s_ += input.dt_s;
  if (outward_S_.isZero(0.0) && beyond_time_s_ > kBeyondS) {
    ++counts_.begun_anew;
    forget();
    return std::nullopt;
  }
  if (!has_patch) return std::nullopt;
  ++counts_.beyond_steps;
  const double depth = (p_SP_ - p_SD).dot(outward_S_);
  if (outward_S_.isZero(0.0) || depth <= 0.0) return output;
  const double plane_force_n = stiffness_n_per_m_ * (depth - kBeyondDampingS * velocity.dot(outward_S_));
  output.force_n = input.X_WS.linear() * (std::clamp(plane_force_n, 0.0, kMaxBeyondForceRatio * force_n_) * outward_S_);
  output.visual_offset_m = input.X_WS.linear() * (depth * outward_S_);
  output.contact = true;
  return output;
}

}  // namespace hapton
