#include "haptics_node/reply_loop.h"
#include "runtime/log.h"

// The part of ReplyLoop that handles carves of the stylus.
namespace hapton {

void ReplyLoop::note_carve() noexcept {
  const MadeCarve* made = step_.made_carve();
  if (made == nullptr) return;
  carve_sender_->note(*made);
  if (carve_undo_ != nullptr) carve_undo_->note(*made);
}

// A request with another source is ignored: its serial is that of a carve by another haptics process.
void ReplyLoop::request_undo(const CarveUndo& request) noexcept {
  if (carve_undo_ != nullptr && request.source == carve_sender_->source()) carve_undo_->request(request.serial);
}

// Called between two samples, so that the force for the next one already includes the restored material.
void ReplyLoop::undo_carves() {
  const auto undone = carve_undo_->work(step_);
  if (!undone) return;
  carve_sender_->note(*undone);
  carve_undo_->note(*undone);
  log_info("carves {} to {} are undone", undone->undone.first, undone->undone.last);
}

void ReplyLoop::send_carves() {
  if (std::exchange(are_carves_full_, carve_sender_->is_full()) != carve_sender_->is_full()) {
    log_warning(
        "{} carves were made, the most that vision nodes can show: carving has stopped; restart haptics_node to begin with whole objects",
        carve_sender_->newest());
  }
  if (hub_.state() != JoinState::joined) return;
  if (const auto carves = carve_sender_->take_due(clock_.now_ns())) hub_.send(*carves);
}

}  // namespace hapton
