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

// Undoes carves: a slow task keeps a second copy of the bodies, carved as those in use. It puts the material of a press of the button back
// there, however long that takes, and the loop that replies to the device then exchanges the two. So a step never waits, and a sample is
// felt either with the material or without it. The replaced copy is brought up to date in the same way. Source: decision 192.
// RT: note, request and work yes. Threads: one caller.
class CarveUndoTask {
 public:
  // whole: the bodies in use before any carve; before: what was carved since then. Takes memory for the bodies twice.
  explicit CarveUndoTask(const Sculpture& whole, std::span<const MadeCarve> before = {});
  ~CarveUndoTask();
  CarveUndoTask(const CarveUndoTask&) = delete;
  CarveUndoTask& operator=(const CarveUndoTask&) = delete;

  // Each entry of the list, in order; those that work() returned as well.
  void note(const MadeCarve& made) noexcept;
  // Requests the undo of the press that a carve with this serial belongs to. One that is undone already, or unknown, changes nothing; a
  // later request replaces one that has not begun.
  void request(std::uint32_t serial) noexcept { requests_.publish(serial); }

  // After a reply: exchanges the bodies, if an undo is ready. Returns its entry of the list, for whoever keeps that.
  std::optional<MadeCarve> work(HapticsStep& step) noexcept;

 private:
  // Whose the copy is: the slow task's until an undo is ready in it, then that of the caller of work().
  enum class Stage : std::uint8_t { idle, ready, taken, behind };
  // Entries that the caller may have to add to the copy itself: as many as it makes while the task hands it over.
  static constexpr std::size_t kMaxMissing = 4;
  using Ring = HandoffRing<MadeCarve, 4096>;  // some seconds of carving

  void run();
  void catch_up();
  bool begin_undo(std::uint32_t serial);
  void put_back(const CarveRange& range);
  void carve(const MadeCarve& made) noexcept;

  const Sculpture whole_;
  Sculpture copy_;
  // The caller's:
  std::array<MadeCarve, kMaxMissing> last_ = {};  // entries, by serial modulo their number
  // The task's:
  CarveList list_;
  // Of both:
  Mailbox<std::uint32_t> requests_;
  std::unique_ptr<Ring> noted_ = std::make_unique<Ring>();
  std::atomic<bool> has_lost_ = false;  // nothing can be undone any more
  std::atomic<Stage> stage_ = Stage::idle;
  CarveRange undone_;         // in the copy; changes while it is the task's
  std::uint32_t synced_ = 0;  // serial up to which the copy has all entries; likewise
  std::atomic<bool> stop_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace hapton
