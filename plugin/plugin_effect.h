#pragma once

#include <memory>
#include <string>

#include "plugin/call_guard.h"
#include "plugin/plugin_file.h"

namespace hapton {

// An effect from a shared library. RT: step and reset yes, if those of the plug-in are; the rest set-up only. Threads: one.
class PluginEffect {
 public:
  // Pre: the clock outlives the effect. Error: one line: the file cannot be used, or the plug-in rejects its parameters.
  static Result<std::unique_ptr<PluginEffect>> make(const PluginChoice& choice, const Clock& clock, std::int64_t budget_ns);
  ~PluginEffect();
  PluginEffect(const PluginEffect&) = delete;
  PluginEffect& operator=(const PluginEffect&) = delete;

  PluginForce step(const hapton_effect_input& input) noexcept;
  void reset() noexcept;

  const std::string& name() const { return name_; }
  const PluginFile& file() const { return file_; }
  const CallGuard& guard() const { return guard_; }

 private:
  PluginEffect(PluginFile file, const hapton_effect_api& api, const Clock& clock, std::int64_t budget_ns);

  PluginFile file_;
  const hapton_effect_api& api_;
  std::string name_;
  void* effect_ = nullptr;
  CallGuard guard_;
};

}  // namespace hapton
