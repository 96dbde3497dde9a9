#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/effects/smooth_velocity.h"
#include "core/force/force_method.h"
#include "plugin/call_guard.h"
#include "plugin/plugin_file.h"

namespace hapton {

// A force method from a shared library. After it is cut off, its last good force fades, and it gives none until another method replaces it.
// RT and threads: as ForceMethod, if the plug-in's functions are.
class PluginMethod final : public ForceMethod {
 public:
  // Pre: the clock outlives the method; the scene is coupled (couple_scene), as make_method does it. Error: one line: the file cannot be
  // used, an object of the scene has no mesh, or the plug-in rejects scene or parameters.
  static Result<std::unique_ptr<PluginMethod>> make(const PluginChoice& choice, const TouchScene& scene, const Clock& clock,
                                                    std::int64_t budget_ns = CallBudget::kDefaultNs);
  ~PluginMethod() override;

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::string describe() const override;

  const std::string& name() const { return name_; }
  const CallGuard& guard() const { return guard_; }
  // For HapticsSetup::method: "plugin:NAME@HASH".
  std::string full_name() const;
  // "method NAME (FILE) is cut off: ...", for the log. Pre: it is cut off.
  std::string notice() const;

 private:
  PluginMethod(PluginFile file, const hapton_method_api& api, const TouchScene& scene, const Clock& clock, std::int64_t budget_ns);
  void call_step(const MethodInput& input, PluginForce& plugin_force);
  void note_hand(const MethodInput& input, hapton_method_input& plugin_input) noexcept;

  PluginFile file_;
  const hapton_method_api& api_;
  std::string name_;
  std::vector<std::shared_ptr<const TriangleMesh>> meshes_;  // the meshes that objects_ points to
  std::vector<hapton_object> objects_;
  std::vector<hapton_material> materials_;  // for set_materials
  void* method_ = nullptr;
  CallGuard guard_;
  MethodOutput last_output_;  // result of the last call
  SmoothVelocity velocity_;
  double time_s_ = 0.0;  // since the first sample after reset
  bool has_sample_ = false;
};

// The name of a method from a file in --method and MethodSettings::name: "plugin", or its full name.
constexpr std::string_view kPluginMethod = "plugin";
inline bool is_plugin_method(std::string_view name) noexcept { return name == kPluginMethod || name.starts_with("plugin:"); }
// True: the word of --method names a file, because it contains ".so".
inline bool names_plugin_file(std::string_view word) noexcept { return word.find(".so") != std::string_view::npos; }

}  // namespace hapton
