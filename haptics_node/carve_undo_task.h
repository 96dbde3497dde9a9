#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <thread>

#include "core/base/mailbox.h"
#include "core/sculpt/carve_list.h"
#include "core/sculpt/sculpture.h"
#include "haptic_step/haptics_step.h"
#include "runtime/handoff_ring.h"

namespace hapton {

// Undoes carves. A slow task keeps a second copy of the bodies, carved like the bodies in use. In this copy it puts the material of a press
// of the button back, however long that takes; the loop that replies to the device then exchanges the two. So a step never waits, and a
// sample is felt either with the material or without it. The task then brings the replaced copy up to date too. Source: decision 192.
// RT: note, request and work yes. Threads: one caller.
class CarveUndoTask {
 public:
  // uncarved: the bodies in use before any carve; earlier_carves: what was carved since then. Takes memory for two more copies of the
  // bodies.
  explicit CarveUndoTask(const Sculpture& uncarved, std::span<const MadeCarve> earlier_carves = {});
  ~CarveUndoTask();
  CarveUndoTask(const CarveUndoTask&) = delete;
  CarveUndoTask& operator=(const CarveUndoTask&) = delete;

  // To be called with each new entry of the list, in order, also with those that work() returned.
  void note(const MadeCarve& made) noexcept;
  // Requests the undo of the press that the carve with this serial belongs to. If the carve is undone already, or unknown, nothing changes.
  // A later request replaces one that has not begun.
  void request(std::uint32_t serial) noexcept { requests_.publish(serial); }

  // To be called after each reply: exchanges the bodies, if an undo is ready. Returns the undo as an entry, for those who keep the list.
  std::optional<MadeCarve> work(HapticsStep& step) noexcept;

 private:
  // Who uses the copy: the caller of work() in the stage ready, that is, once an undo is ready in the copy; otherwise the slow task.
  enum class Stage : std::uint8_t { idle, ready, taken, behind };
  // Entries that the caller may have to add to the copy itself: as many as it makes while the task hands it over.
  static constexpr std::size_t kMaxMissing = 4;
  using Ring = HandoffRing<MadeCarve, 4096>;  // some seconds of carving

  void run();
  void catch_up();
  bool begin_undo(std::uint32_t serial);
  void put_back(const CarveRange& range);
  void carve(const MadeCarve& made) noexcept;

  const Sculpture uncarved_;
  Sculpture copy_;
  // The caller's:
  std::array<MadeCarve, kMaxMissing> last_entries_ = {};  // the last entries; the index is serial % kMaxMissing
  // The task's:
  CarveList list_;
  // Used by both:
  Mailbox<std::uint32_t> requests_;
  std::unique_ptr<Ring> new_entries_ = std::make_unique<Ring>();
  std::atomic<bool> has_lost_entries_ = false;  // nothing can be undone any more
  std::atomic<Stage> stage_ = Stage::idle;
  CarveRange undone_;                // the carves undone in the copy; changes while the task uses the copy
  std::uint32_t copied_serial_ = 0;  // serial up to which the copy has all entries; changes likewise
  std::atomic<bool> stop_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace hapton
