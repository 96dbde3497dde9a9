#include "haptics_node/carve_undo_task.h"

#include <algorithm>
#include <chrono>

#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// Between two polls for requests: a person does not notice it, and a thread that sleeps so long takes no time from the force.
constexpr std::chrono::milliseconds kUndoPollPeriod(5);

}  // namespace

CarveUndoTask::CarveUndoTask(const Sculpture& uncarved, std::span<const MadeCarve> earlier_carves) : uncarved_(uncarved), copy_(uncarved) {
  for (const MadeCarve& made : earlier_carves) {
    list_.add(made);
    carve(made);
    last_entries_[made.serial % kMaxMissing] = made;
  }
  copied_serial_ = list_.newest();
  thread_ = start_thread([this] { run(); });
}

CarveUndoTask::~CarveUndoTask() {
  stop_ = true;
  thread_.join();
}

void CarveUndoTask::note(const MadeCarve& made) noexcept {
  last_entries_[made.serial % kMaxMissing] = made;
  if (!new_entries_->push(made)) has_lost_entries_ = true;
}

std::optional<MadeCarve> CarveUndoTask::work(HapticsStep& step) noexcept {
  if (stage_.load(std::memory_order_acquire) != Stage::ready) return std::nullopt;
  const std::uint32_t newest = step.touch().newest_carve_serial();
  if (newest < copied_serial_) {  // the bodies were replaced
    has_lost_entries_ = true;
    stage_.store(Stage::idle, std::memory_order_release);
    return std::nullopt;
  }
  if (newest - copied_serial_ > kMaxMissing) {
    stage_.store(Stage::behind, std::memory_order_release);
    return std::nullopt;
  }
  for (std::uint32_t serial = copied_serial_ + 1; serial <= newest; ++serial) carve(last_entries_[serial % kMaxMissing]);
  const CarveRange undone = undone_;
  const bool is_done = newest < Sculpture::kMaxCarves && step.restore_carves(copy_, newest + 1);
  if (!is_done) has_lost_entries_ = true;  // the bodies were replaced, or no serial is left
  stage_.store(is_done ? Stage::taken : Stage::idle, std::memory_order_release);
  if (!is_done) return std::nullopt;
  return MadeCarve{.serial = newest + 1, .undone = undone};
}

void CarveUndoTask::carve(const MadeCarve& made) noexcept {
  for (std::size_t body = 0; body < copy_.bodies().size(); ++body) {
    if (!made.is_undo() && copy_.bodies()[body].object == made.object) copy_.field(body).carve(made.carve);
  }
}

void CarveUndoTask::run() {
  std::uint32_t pending = 0;
  while (!stop_) {
    const Stage stage = stage_.load(std::memory_order_acquire);
    if (stage == Stage::taken) put_back(undone_);  // in the copy that was in use until now
    if (stage != Stage::ready) {
      // Takes the request first: then the list has all that was carved before the request came.
      if (requests_.take()) pending = requests_.value();
      catch_up();
      // An undo that did not come into use, because carves were made meanwhile, is still in the copy.
      const bool is_again = stage == Stage::behind;
      const bool is_ready = is_again || (pending != 0 && begin_undo(pending));
      if (!is_again) pending = 0;
      stage_.store(is_ready ? Stage::ready : Stage::idle, std::memory_order_release);
    }
    std::this_thread::sleep_for(kUndoPollPeriod);
  }
}

// A carve whose undo is already in the list is not carved into the copy: the copy must not have it.
void CarveUndoTask::catch_up() {
  MadeCarve made;
  while (new_entries_->pop(made)) {
    list_.add(made);
    if (list_.is_active(made.serial)) carve(made);
    copied_serial_ = made.serial;
  }
}

bool CarveUndoTask::begin_undo(std::uint32_t serial) {
  if (has_lost_entries_) {
    log_warning("carves can no longer be undone in this haptics_node: there are too many, or the scene has other bodies; start it again");
    return false;
  }
  if (!list_.is_active(serial)) return false;
  const CarveRange press = list_.find_press(serial);
  if (press.is_empty()) return false;
  // The copy is without these carves from here on; the entry of this undo follows once the copy is in use.
  undone_ = press;
  put_back(press);
  return true;
}

void CarveUndoTask::put_back(const CarveRange& range) {
  list_.undo(range);
  for (std::size_t body = 0; body < copy_.bodies().size(); ++body) {
    restore_undone(list_, copy_.bodies()[body].object, range, uncarved_.bodies()[body].field, copy_.field(body));
  }
}

}  // namespace hapton
