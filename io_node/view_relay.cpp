#include "io_node/view_relay.h"

namespace hapton {

bool ViewRelay::accept(const ViewTransform& view, std::int64_t now_ns) noexcept {
  const bool has_moved = view.X_WS != view_.value_or(ViewTransform{}).X_WS;
  view_ = view;
  stats_.views_forwarded += peers_.send_to_role(NodeRole::haptics, view);
  next_repeat_ns_ = now_ns + kRepeatNs;
  return has_moved;
}

void ViewRelay::on_haptics_joined(std::size_t peer, std::int64_t now_ns) noexcept {
  if (!view_) return;
  stats_.views_forwarded += peers_.send_to(peer, *view_) ? 1 : 0;
  next_repeat_ns_ = now_ns + kRepeatNs;
}

void ViewRelay::repeat_if_due(std::int64_t now_ns) noexcept {
  if (!view_ || now_ns < next_repeat_ns_) return;
  next_repeat_ns_ = now_ns + kRepeatNs;
  peers_.send_to_role(NodeRole::haptics, *view_);
}

std::uint32_t ViewRelay::revision_in_use(const ProbeHistory& history) const noexcept {
  const bool has_reply = peers_.has_haptics() && !history.is_haptics_new();
  if (has_reply) return history.last_reply().view_revision;
  return view_ ? view_->revision : 0;
}

}  // namespace hapton
