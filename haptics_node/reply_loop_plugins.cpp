#include "haptic_step/haptics_setup.h"
#include "haptics_node/reply_loop.h"
#include "plugin/plugin_method.h"
#include "runtime/log.h"

// The part of ReplyLoop that handles effects and methods from shared libraries.
namespace hapton {

bool ReplyLoop::is_method_cut_off() const noexcept {
  const auto* method = dynamic_cast<const PluginMethod*>(&step_.touch().method());
  return method != nullptr && method->guard().cut_off();
}

void ReplyLoop::report_plugins() {
  const bool is_effect = effects_ != nullptr && effects_->has_notices();
  const bool is_method = is_method_cut_off() != is_method_cut_off_;
  if (!is_effect && !is_method) return;
  if (is_effect) {
    for (const std::string& notice : effects_->take_notices()) log_warning("{}", notice);
  }
  if (is_method) {
    is_method_cut_off_ = !is_method_cut_off_;
    if (is_method_cut_off_) log_warning("{}", dynamic_cast<const PluginMethod&>(step_.touch().method()).notice());
  }
  show_plugins();
  send_setup_soon();
}

// The setup, and so recordings and reports, name plug-ins that were cut off: this depends on how long calls took and cannot be replayed.
void ReplyLoop::show_plugins() {
  put_text((effects_ != nullptr ? effects_->to_text() : std::string()) + (is_method_cut_off_ ? " cut=method" : ""), effects_text_);
  show_method_in_use();
}

}  // namespace hapton
