#include "core/tool/tool_step.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace hapton {
namespace {

ToolCoupling completed(ToolCoupling coupling, double mean_squared_lever) {
  if (!(coupling.rotational_stiffness_nm_per_rad > 0.0)) {
    coupling.rotational_stiffness_nm_per_rad = coupling.stiffness_n_per_m * mean_squared_lever;
  }
  return coupling;
}

double turn_length_m(const ToolCoupling& coupling) {
  return std::sqrt(coupling.rotational_stiffness_nm_per_rad / coupling.stiffness_n_per_m);
}

Result<void> check(const ToolCoupling& coupling, const std::vector<CoulombFriction>& friction) {
  if (!(coupling.stiffness_n_per_m > 0.0) || !std::isfinite(coupling.stiffness_n_per_m)) {
    return fail("the tool's stiffness is {} N/m; give a positive one", coupling.stiffness_n_per_m);
  }
  if (!(coupling.rotational_stiffness_nm_per_rad >= 0.0) || !std::isfinite(coupling.rotational_stiffness_nm_per_rad)) {
    return fail("the tool's rotational stiffness is {} Nm/rad; give a positive one, or 0 for one derived from its size",
                coupling.rotational_stiffness_nm_per_rad);
  }
  for (const CoulombFriction& one : friction) {
    if (!(one.friction_dynamic >= 0.0) || !(one.friction_dynamic <= one.friction_static) || !std::isfinite(one.friction_static)) {
      return fail("the friction of a surface is {} (static) and {} (dynamic); give 0 or more, the dynamic one not above the static one",
                  one.friction_static, one.friction_dynamic);
    }
  }
  return {};
}

bool is_rough(const std::vector<CoulombFriction>& friction) {
  return std::ranges::any_of(friction, [](const CoulombFriction& one) { return one.friction_static > 0.0; });
}

std::vector<std::shared_ptr<const ObjectGeometry>> geometries_of(const std::vector<std::shared_ptr<const ContactSurface>>& objects) {
  std::vector<std::shared_ptr<const ObjectGeometry>> geometries;
  for (const auto& object : objects) geometries.emplace_back(object, &object->geometry());
  return geometries;
}

// The number of parts that move by themselves; 0: none does.
Result<std::size_t> count_moving(const std::vector<int>& part_of) {
  const int moving = part_of.empty() ? 0 : std::max(0, *std::max_element(part_of.begin(), part_of.end()));
  if (moving > ToolStep::kMaxParts) {
    return fail("{} parts of the scene move by themselves; a rigid tool touches {} at most: let some stand still, or move together", moving,
                ToolStep::kMaxParts);
  }
  return static_cast<std::size_t>(moving);
}

std::size_t part_of_object(const std::vector<int>& part_of, std::size_t object) {
  return object < part_of.size() ? static_cast<std::size_t>(std::max(part_of[object], 0)) : 0;
}

constexpr char kNoToolTriangles[] = "the tool has no triangles";
constexpr char kNoSceneTriangles[] = "the scene has no triangles";

}  // namespace

double find_mean_squared_lever(const TriangleMesh& tool, const Vec3& grip) {
  double area = 0.0;
  double sum = 0.0;
  for (std::size_t t = 0; t < tool.triangles.size(); ++t) {
    const Vec3 a = tool.corner(t, 0) - grip;
    const Vec3 b = tool.corner(t, 1) - grip;
    const Vec3 c = tool.corner(t, 2) - grip;
    const double twice = (b - a).cross(c - a).norm();
    area += twice;
    sum += twice * (a.squaredNorm() + b.squaredNorm() + c.squaredNorm() + (a + b + c).squaredNorm()) / 12.0;
  }
  return area > 0.0 ? sum / area * 2.0 / 3.0 : 0.0;
}

Result<std::unique_ptr<ToolStep>> ToolStep::make(const TriangleMesh& tool, std::vector<std::shared_ptr<const TriangleMesh>> scene,
                                                 const ToolCoupling& coupling, std::vector<CoulombFriction> friction,
                                                 std::unique_ptr<WorkerTeam> team, const std::vector<int>& parts) {
  if (tool.triangles.empty()) return fail(kNoToolTriangles);
  std::size_t triangles = 0;
  for (const auto& mesh : scene) triangles += mesh->triangles.size();
  if (triangles == 0) return fail(kNoSceneTriangles);
  if (const auto usable = check(coupling, friction); !usable) return tl::unexpected(usable.error());
  if (const auto numbered = TouchGeometry::check(scene); !numbered) return tl::unexpected(numbered.error());
  const auto moving = count_moving(parts);
  if (!moving) return tl::unexpected(moving.error());
  std::vector<Objects> objects(*moving + 1);
  Box box;
  for (std::size_t o = 0; o < scene.size(); ++o) {
    Objects& part = objects[part_of_object(parts, o)];
    if (*moving > 0) box.grow(Box::of(scene[o]->vertices));
    part.meshes.push_back(std::move(scene[o]));
    part.friction.push_back(o < friction.size() ? friction[o] : CoulombFriction());
  }
  const ToolCoupling whole = completed(coupling, find_mean_squared_lever(tool));
  auto step = std::unique_ptr<ToolStep>(new ToolStep(tool, std::move(objects), box, whole, std::move(team)));
  step->part_of_ = parts;
  return checked(std::move(step));
}

Result<std::unique_ptr<ToolStep>> ToolStep::make(const PreparedTool& prepared, const ToolCoupling& coupling,
                                                 std::vector<CoulombFriction> friction, std::unique_ptr<WorkerTeam> team) {
  if (prepared.tool->geometry().triangle_count() == 0) return fail(kNoToolTriangles);
  const auto has_triangles = [](const auto& object) { return object->geometry().triangle_count() > 0; };
  if (!std::any_of(prepared.scene.begin(), prepared.scene.end(), has_triangles)) return fail(kNoSceneTriangles);
  if (const auto usable = check(coupling, friction); !usable) return tl::unexpected(usable.error());
  const auto moving = count_moving(prepared.part_of);
  if (!moving) return tl::unexpected(moving.error());
  std::vector<PreparedPart> parts(*moving + 1);
  for (std::size_t o = 0; o < prepared.scene.size(); ++o) {
    PreparedPart& part = parts[part_of_object(prepared.part_of, o)];
    part.surfaces.push_back(prepared.scene[o]);
    part.friction.push_back(o < friction.size() ? friction[o] : CoulombFriction());
  }
  const ToolCoupling whole = completed(coupling, prepared.mean_squared_lever);
  return checked(std::unique_ptr<ToolStep>(new ToolStep(prepared, std::move(parts), whole, std::move(team))));
}

Result<std::unique_ptr<ToolStep>> ToolStep::checked(std::unique_ptr<ToolStep> step) {
  constexpr double kMaxSizes = 1e6;
  const double size = step->proxy_.radius();
  const double turn_length = turn_length_m(step->coupling_) / step->scene_.unit_m();
  if (!(size > 0.0) || !(turn_length > 0.0)) return fail("the tool has no surface about its grip point");
  if (!(size <= kMaxSizes)) return fail("the tool is {:.3g} times as large as the scene; check the units of both", size);
  step->set_damping({});
  return step;
}

ToolStep::ToolStep(const TriangleMesh& tool, std::vector<Objects> parts, const Box& box, const ToolCoupling& coupling,
                   std::unique_ptr<WorkerTeam> team)
    : team_(std::move(team)),
      coupling_(coupling),
      squared_lever_m2_(coupling.rotational_stiffness_nm_per_rad / coupling.stiffness_n_per_m),
      scene_(std::move(parts[0].meshes), BuildPolicy::at_once, std::nullopt, box),
      tool_(ObjectGeometry::make(tool, {Vec3::Zero(), scene_.unit_m()}, 2 * tool.triangles.size())),
      proxy_(tool_, scene_, turn_length_m(coupling_) / scene_.unit_m(), parts[0].friction, team_ ? *team_ : calling_thread()) {
  has_friction_ = std::ranges::any_of(parts, [](const Objects& part) { return is_rough(part.friction); });
  for (std::size_t p = 1; p < parts.size(); ++p) {
    moving_.push_back(std::make_unique<TouchGeometry>(std::move(parts[p].meshes), BuildPolicy::at_once, std::nullopt, box));
    proxy_.add_part(*moving_.back(), std::make_shared<const SceneSurface>(*moving_.back()), std::move(parts[p].friction));
  }
  parts_.resize(moving_.size());
}

ToolStep::ToolStep(const PreparedTool& prepared, std::vector<PreparedPart> parts, const ToolCoupling& coupling,
                   std::unique_ptr<WorkerTeam> team)
    : team_(std::move(team)),
      coupling_(coupling),
      squared_lever_m2_(coupling.rotational_stiffness_nm_per_rad / coupling.stiffness_n_per_m),
      has_friction_(std::ranges::any_of(parts, [](const PreparedPart& part) { return is_rough(part.friction); })),
      q_DT_(prepared.q_DT),
      scene_(geometries_of(parts[0].surfaces), prepared.frame),
      part_of_(prepared.part_of),
      tool_(prepared.tool->geometry().with_origin_at(prepared.grip)),
      proxy_(tool_, std::make_shared<const ToolSurface>(prepared.tool, prepared.grip, tool_), scene_,
             std::make_shared<const SceneSurface>(parts[0].surfaces, scene_), turn_length_m(coupling_) / scene_.unit_m(), parts[0].friction,
             team_ ? *team_ : calling_thread()) {
  for (std::size_t p = 1; p < parts.size(); ++p) {
    moving_.push_back(std::make_unique<TouchGeometry>(geometries_of(parts[p].surfaces), prepared.frame));
    proxy_.add_part(*moving_.back(), std::make_shared<const SceneSurface>(parts[p].surfaces, *moving_.back()),
                    std::move(parts[p].friction));
  }
  parts_.resize(moving_.size());
}

void ToolStep::to_local(std::span<const Pose> X_SO, std::span<Placement> parts) const noexcept {
  for (std::size_t p = 0; p < std::min(X_SO.size(), parts.size()); ++p) {
    if (!X_SO[p].matrix().allFinite()) continue;
    parts[p] = {scene_.to_local(X_SO[p] * scene_.origin()), Quat(X_SO[p].linear()).normalized()};
  }
}

Placement ToolStep::to_local(const ToolInput& input) const noexcept {
  const Pose X_SD = input.X_WS.inverse(Eigen::Isometry) * input.X_WD;
  const Quat q_SD = Quat(X_SD.linear()).normalized();
  return {scene_.to_local(X_SD.translation()), q_DT_ ? (q_SD * *q_DT_).normalized() : q_SD};
}

std::size_t ToolStep::part_of(std::size_t object) const noexcept { return part_of_object(part_of_, object); }

void ToolStep::set_stiffness(double n_per_m) noexcept {
  coupling_ = {.stiffness_n_per_m = n_per_m, .rotational_stiffness_nm_per_rad = n_per_m * squared_lever_m2_};
}

void ToolStep::reset(const ToolInput& input) noexcept {
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return;
  last_device_ = to_local(input);
  to_local(input.X_SO, parts_);
  proxy_.reset(last_device_, parts_);
  friction_.forget();
  damping_.reset();
}

ToolOutput ToolStep::felt_at(const ToolInput& input, const Placement& device, const Placement& proxy) const noexcept {
  ToolOutput output;
  output.X_WP = input.X_WD;
  const Vec3 shift_m = scene_.unit_m() * (proxy.position - device.position);
  const Vec3 turn = turn_between(device.orientation, proxy.orientation);
  output.contact = !shift_m.isZero(0.0) || !turn.isZero(0.0);
  if (!output.contact) return output;
  const Mat3 R_WS = input.X_WS.linear();
  output.force_n = coupling_.stiffness_n_per_m * (R_WS * shift_m);
  output.torque_nm = coupling_.rotational_stiffness_nm_per_rad * (R_WS * turn);
  output.X_WP.translation() = input.X_WD.translation() + R_WS * shift_m;
  output.X_WP.linear() = R_WS * turn_by(turn).toRotationMatrix() * R_WS.transpose() * input.X_WD.linear();
  return output;
}

ToolOutput ToolStep::step(const ToolInput& input) noexcept {
  ToolOutput output;
  output.X_WP = input.X_WD;
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return output;
  const Placement device = to_local(input);
  to_local(input.X_SO, parts_);
  const ToolProxyStep proxy_step = has_friction_ ? follow(device) : proxy_.step(device, parts_);
  if (!proxy_step.is_blocked) output = felt_at(input, device, proxy_.placement());
  output.torque_nm *= torque_share(turn_between(device.orientation, proxy_.placement().orientation));
  output.proxy = proxy_step;
  if (damping_.is_on()) {
    note_view(input, last_view_, damping_);
    damping_.move(device, parts_, input.dt_s);
    add_damping(input, output);
  }
  return output;
}

void ToolStep::note_view(const ToolInput& input, ToolView& last, ContactDamping& damping) const noexcept {
  if (last.X_WS.matrix() != input.X_WS.matrix()) damping.move_last(to_local({.X_WD = last.X_WD, .X_WS = input.X_WS}));
  last = {input.X_WD, input.X_WS};
}

Result<void> ToolStep::damp(const std::vector<DampingCoefficients>& damping) {
  for (const DampingCoefficients& one : damping) {
    if (!(one.normal_ns_per_m >= 0.0) || !(one.along_ns_per_m >= 0.0) || !std::isfinite(one.normal_ns_per_m + one.along_ns_per_m)) {
      return fail("the damping of a surface is {} Ns/m along its normal and {} Ns/m along it; give 0 or more", one.normal_ns_per_m,
                  one.along_ns_per_m);
    }
  }
  set_damping(damping);
  return {};
}

void ToolStep::set_damping(const std::vector<DampingCoefficients>& damping) {
  std::size_t objects = scene_.object_count();
  for (const auto& part : moving_) objects += part->object_count();
  std::vector<std::vector<DampingCoefficients>> by_part(moving_.size() + 1);
  for (std::size_t o = 0; o < objects; ++o) {
    by_part[part_of(o)].push_back(o < damping.size() ? damping[o] : DampingCoefficients());
  }
  damping_ = ContactDamping(std::move(by_part), scene_.unit_m(), proxy_.radius());
}

std::size_t list_damping_contacts(const LocalContacts& local, const LocalContacts::Solution& solution, double unit_force_n,
                                  std::array<ContactDamping::Contact, ContactDamping::kMaxContacts>& contacts) noexcept {
  const auto count = static_cast<std::size_t>(solution.active_count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(solution.active[k]);
    const LocalContact& contact = local.contacts[i];
    contacts[k] = {contact.arm, local.bounds[i].row.head<3>(), unit_force_n * solution.multipliers[static_cast<int>(k)], contact.part,
                   contact.object};
  }
  return count;
}

void ToolStep::add_damping(const ToolInput& input, ToolOutput& output) noexcept {
  std::array<ContactDamping::Contact, ContactDamping::kMaxContacts> contacts;
  std::size_t count = 0;
  if (output.contact && has_friction_) {
    count = list_damping_contacts(local_, solution_, unit_force_n(), contacts);
  } else if (output.contact) {
    for (const ToolContact& contact : proxy_.contacts()) {
      const TouchGeometry& scene = contact.part > 0 ? *moving_[static_cast<std::size_t>(contact.part) - 1] : scene_;
      contacts[count++] = {contact.point - proxy_.placement().position, contact.normal, unit_force_n() * contact.multiplier, contact.part,
                           scene.mesh_of(contact.scene_triangle)};
    }
  }
  const ContactDamping::Wrench damping = damping_.step({contacts.data(), count}, output.contact);
  output.force_n += input.X_WS.linear() * damping.force_n;
  output.torque_nm += input.X_WS.linear() * damping.torque_nm;
}

// Computes friction from the contacts at the pose of the proxy, then lets the proxy follow to where friction holds the tool.
ToolProxyStep ToolStep::follow(const Placement& device) noexcept {
  const double moved = motion_between(last_device_, device).length(proxy_.radius());
  last_device_ = device;
  proxy_.find_local_contacts(device, parts_, proxy_.local_reach(moved + proxy_.travel_to(parts_)), local_);
  local_.follow(parts_);
  const ToolFriction::Step friction_step = friction_.step(local_, device, parts_);
  solution_ = friction_step.solution;
  const ToolProxyStep proxy_step = proxy_.step(friction_step.goal, parts_);
  friction_.move_to(proxy_.placement());
  return proxy_step;
}

std::string ToolStep::describe() const {
  std::size_t triangles = scene_.triangle_count();
  std::size_t objects = scene_.object_count();
  for (const auto& part : moving_) {
    triangles += part->triangle_count();
    objects += part->object_count();
  }
  std::string text = fmt::format(
      "tool: {} triangles, {:.4g} m from its grip point; scene: {} triangles in {} objects\n"
      "coupling: {:.6g} N/m, {:.4g} Nm/rad; contact offset {:.3g} um; at most {} rounds of {} pairs of features a step\n",
      tool_.triangle_count(), proxy_.radius() * scene_.unit_m(), triangles, objects, coupling_.stiffness_n_per_m,
      coupling_.rotational_stiffness_nm_per_rad, 1e6 * ToolProxy::kContactOffset * scene_.unit_m(), ToolProxy::kMaxRounds,
      NearFeatures::kMaxFeatures);
  if (!moving_.empty()) {
    text += fmt::format("objects that move by themselves: {}, in parts: {}\n", objects - scene_.object_count(), moving_.size());
  }
  return text;
}

}  // namespace hapton
