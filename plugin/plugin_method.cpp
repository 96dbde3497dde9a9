#include "plugin/plugin_method.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/force/touch_step.h"

namespace hapton {
namespace {

// A plug-in reads the arrays of a mesh in place, without conversion.
static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(std::uint32_t));

hapton_material to_plugin(const Material& material) noexcept {
  return {material.stiffness_n_per_m, material.damping_ns_per_m,  material.friction_static,
          material.friction_dynamic,  material.two_sided ? 1 : 0, 0};
}

hapton_object to_plugin(const TouchObject& object) noexcept {
  const TriangleMesh& mesh = *object.mesh;
  return {mesh.vertices.empty() ? nullptr : mesh.vertices.front().data(), mesh.triangles.empty() ? nullptr : mesh.triangles.front().data(),
          mesh.vertices.size(), mesh.triangles.size(), to_plugin(object.material)};
}

}  // namespace

PluginMethod::PluginMethod(PluginFile file, const hapton_method_api& api, const TouchScene& scene, const Clock& clock,
                           std::int64_t budget_ns)
    : file_(std::move(file)), api_(api), name_(clean_plugin_name(api.name)), guard_(clock, budget_ns, api.max_force_n, 0.0) {
  for (const TouchObject& object : scene.objects) {
    meshes_.push_back(object.mesh);
    objects_.push_back(to_plugin(object));
    materials_.push_back(objects_.back().material);
  }
}

Result<std::unique_ptr<PluginMethod>> PluginMethod::make(const PluginChoice& choice, const TouchScene& scene, const Clock& clock,
                                                         std::int64_t budget_ns) {
  auto file = PluginFile::open(choice);
  if (!file) return tl::unexpected(file.error());
  const auto api = file->find_method();
  if (!api) return tl::unexpected(api.error());
  for (const TouchObject& object : scene.objects) {
    if (object.mesh == nullptr) return fail("{}: an object of the scene has no mesh; give it one", file->path());
  }
  std::unique_ptr<PluginMethod> made(new PluginMethod(std::move(*file), **api, scene, clock, budget_ns));
  const PluginRequest request(made->file_.choice());
  const bool has_returned =
      call_plugin([&] { made->method_ = made->api_.create(request.get(), made->objects_.data(), made->objects_.size()); });
  if (!has_returned) return fail("{}: {} threw a C++ exception in create", made->file_.path(), made->name_);
  if (made->method_ == nullptr) return tl::unexpected(request.rejection(made->name_));
  return made;
}

PluginMethod::~PluginMethod() {
  if (method_ != nullptr && api_.destroy != nullptr) call_plugin([&] { api_.destroy(method_); });
}

// The velocity is that of the hand in the world: turning the scene does not change it.
void PluginMethod::note_hand(const MethodInput& input, hapton_method_input& plugin_input) noexcept {
  const TouchInput in_scene{.p_WD = input.p_SD, .buttons = input.buttons};
  const TouchInput& touch = input.touch != nullptr ? *input.touch : in_scene;
  velocity_.add(touch.p_WD, input.dt_s);
  time_s_ += has_sample_ ? input.dt_s : 0.0;
  has_sample_ = true;
  const Mat3 R_SW = touch.X_WS.linear().transpose();
  const Vec3 v_S = R_SW * velocity_.mean();
  const Quat q_ST = Quat(R_SW) * touch.q_WT;
  const double orientation[] = {q_ST.w(), q_ST.x(), q_ST.y(), q_ST.z()};
  std::copy_n(orientation, 4, plugin_input.orientation);
  std::copy_n(v_S.data(), 3, plugin_input.velocity_m_per_s);
  plugin_input.time_s = time_s_;
  plugin_input.buttons = touch.buttons;
}

void PluginMethod::call_step(const MethodInput& input, PluginForce& plugin_force) {
  hapton_method_input plugin_input = {};
  plugin_input.dt_s = input.dt_s;
  note_hand(input, plugin_input);
  hapton_method_output output = {};
  for (int k = 0; k < 3; ++k) plugin_input.position_m[k] = output.proxy_m[k] = input.p_SD[k];
  output.object = -1;
  api_.step(method_, &plugin_input, &output);
  last_output_.contact = output.contact != 0;
  last_output_.p_SP = Vec3(output.proxy_m[0], output.proxy_m[1], output.proxy_m[2]);
  last_output_.object = output.object >= 0 && output.object < static_cast<int>(objects_.size()) ? output.object : -1;
  if (last_output_.contact) plugin_force.force_n = Vec3(output.force_n[0], output.force_n[1], output.force_n[2]);
  if (!last_output_.p_SP.allFinite()) plugin_force.force_n.setConstant(std::numeric_limits<double>::quiet_NaN());
}

MethodOutput PluginMethod::step(const MethodInput& input) noexcept {
  MethodOutput output;
  output.p_SP = input.p_SD;
  // A plug-in is called only for the step of a sample; a step without a duration belongs to none.
  if (!input.p_SD.allFinite() || !(input.dt_s > 0.0)) return output;
  const PluginForce guarded_force = guard_.step(input.dt_s, [&](PluginForce& plugin_force) { call_step(input, plugin_force); });
  output.force_n = guarded_force.force_n;
  output.contact = !guarded_force.force_n.isZero(0.0);
  if (guard_.cut_off() || !last_output_.contact) return output;
  output.contact = true;
  output.p_SP = last_output_.p_SP;
  output.object = last_output_.object;
  return output;
}

void PluginMethod::reset(const Vec3& p_SD) noexcept {
  guard_.forget();
  velocity_.reset();
  time_s_ = 0.0;
  has_sample_ = false;
  if (guard_.cut_off() || !p_SD.allFinite()) return;
  if (!call_plugin([&] { api_.reset(method_, p_SD.data()); })) guard_.cut({.reason = CutOff::Reason::exception});
}

void PluginMethod::set_materials(std::span<const Material> materials) noexcept {
  if (guard_.cut_off() || api_.set_materials == nullptr) return;
  const std::size_t count = std::min(materials.size(), materials_.size());
  std::transform(materials.begin(), materials.begin() + static_cast<std::ptrdiff_t>(count), materials_.begin(),
                 [](const Material& material) { return to_plugin(material); });
  const bool has_returned = call_plugin([&] { api_.set_materials(method_, materials_.data(), materials_.size()); });
  if (!has_returned) guard_.cut({.reason = CutOff::Reason::exception});
}

std::string PluginMethod::full_name() const { return fmt::format("{}:{}@{:016x}", kPluginMethod, name_, file_.hash()); }

std::string PluginMethod::describe() const {
  return fmt::format("method {} ({}): {}", name_, file_.choice().to_text(), describe_calls(guard_));
}

std::string PluginMethod::notice() const {
  return fmt::format("method {} ({}) is cut off: {}; its force fades and the scene is not felt. hapton set --method proxy, or start again",
                     name_, file_.path(), hapton::describe(guard_.cut_off()));
}

}  // namespace hapton
