#include "haptics_node/shape_maker.h"

#include <string>
#include <utility>

#include "haptic_step/haptics_setup.h"

namespace hapton {
namespace {

WantedShape make_rest(std::size_t vertices) {
  WantedShape rest;
  rest.displacements_m.resize(vertices);
  return rest;
}

}  // namespace

ShapeMaker::ShapeMaker(const StreamedMethod& method, const ProgramShape& shape)
    : stager_(method.stager()), shape_(shape), wanted_(make_rest(stager_.rest().size())), next_start_(method.current_stage().to) {}

ShapeMaker::~ShapeMaker() {
  delete made_.load();
  delete retired_.load();
}

std::unique_ptr<MadeShape> ShapeMaker::take() noexcept {
  // retired_ has room for one shape, so none is taken before it is empty.
  if (made_.load(std::memory_order_relaxed) == nullptr || retired_.load(std::memory_order_acquire) != nullptr) return nullptr;
  return std::unique_ptr<MadeShape>(made_.exchange(nullptr, std::memory_order_acq_rel));
}

void ShapeMaker::note_taken() noexcept {
  next_start_ = std::move(offered_end_);
  offered_ = nullptr;
}

void ShapeMaker::reject(const std::string& why) {
  RejectedShape& rejected = rejections_.draft();
  rejected.stream = wanted_.value().stream;
  rejected.shape = wanted_.value().shape;
  put_text(why, rejected.why);
  rejections_.publish_draft();
}

bool ShapeMaker::work() {
  delete retired_.exchange(nullptr, std::memory_order_acq_rel);
  if (offered_ != nullptr && made_.load(std::memory_order_acquire) != offered_) note_taken();
  is_pending_ = wanted_.take() || is_pending_;
  if (!is_pending_) return false;
  const WantedShape& wanted = wanted_.value();
  std::vector<Vec3> to = shape_.vertices_of(stager_.rest(), wanted.displacements_m);
  auto stage = stager_.make(next_start_, to);
  if (!stage) {
    reject(stage.error().what);
    is_pending_ = false;
    return true;
  }
  auto made = std::make_unique<MadeShape>(MadeShape{wanted, std::move(*stage)});
  // Only the loop that replies to the device takes a shape, and only this function offers one. If the previous offer is still there, it was
  // not taken, and the new stage begins at the right place. Otherwise the next call makes the stage again, from where the shape that was
  // taken ends.
  MadeShape* before = offered_;
  if (!made_.compare_exchange_strong(before, made.get(), std::memory_order_acq_rel)) {
    note_taken();
    return true;
  }
  delete before;
  offered_ = made.release();
  offered_end_ = std::move(to);
  is_pending_ = false;
  return true;
}

}  // namespace hapton
