#include "io_node/view_relay.h"

namespace hapton {

bool ViewRelay::accept(const ViewTransform& view, std::size_t peer, std::int64_t now_ns) noexcept {
  // Revisions wrap around at 2^32, so the sign of their difference tells which is newer.
  const bool is_ahead = !view_ || static_cast<std::int32_t>(view.revision - view_->revision) > 0;
  if (owner_ != kNobody && owner_ != peer && !is_ahead) {
    peers_.send_to(peer, *view_);
    return false;
  }
  const bool has_moved = view.X_WS != view_.value_or(ViewTransform{}).X_WS;
  view_ = view;
  owner_ = peer;
  stats_.views_forwarded += peers_.send_to_role(NodeRole::haptics, view);
  show_others();
  next_repeat_ns_ = now_ns + kRepeatNs;
  return has_moved;
}

bool ViewRelay::accept(const HapticsSetup& setup) noexcept {
  if (view_ || setup.view_revision == 0) return false;
  view_ = ViewTransform{setup.view_revision, setup.X_WS};
  show_others();
  return true;
}

void ViewRelay::on_joined(std::size_t peer, std::int64_t now_ns) noexcept {
  on_left(peer);
  if (!view_) return;
  const bool is_sent = peers_.send_to(peer, *view_);
  if (peers_.peer(peer).role != NodeRole::haptics) return;
  stats_.views_forwarded += is_sent ? 1 : 0;
  next_repeat_ns_ = now_ns + kRepeatNs;
}

void ViewRelay::on_left(std::size_t peer) noexcept {
  if (owner_ == peer) owner_ = kNobody;
}

void ViewRelay::repeat_if_due(std::int64_t now_ns) noexcept {
  if (!view_ || now_ns < next_repeat_ns_) return;
  next_repeat_ns_ = now_ns + kRepeatNs;
  peers_.send_to_role(NodeRole::haptics, *view_);
  show_others();
}

void ViewRelay::show_others() noexcept {
  for (std::size_t peer = 0; peer < HubPeers::kCapacity; ++peer) {
    if (peer != owner_ && peers_.peer(peer).present && peers_.peer(peer).role == NodeRole::vision) peers_.send_to(peer, *view_);
  }
}

std::uint32_t ViewRelay::revision_in_use(const ProbeHistory& history) const noexcept {
  const bool has_reply = peers_.has_haptics() && !history.is_haptics_new();
  if (has_reply) return history.last_reply().view_revision;
  return view_ ? view_->revision : 0;
}

}  // namespace hapton
