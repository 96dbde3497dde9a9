#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/touch_scene.h"

namespace hapton {

// Whether a point is inside a body of the scene: enclosed by faces that point outwards. What moves by itself is left out, and so is what
// has more than small holes. two_sided: such a body is felt from within; one that can be carved is not. Brute force over the bodies whose
// box holds the point: 0.1 s for a million triangles. Frame S. RT: no.
struct Enclosure {
  bool is_inside = false;
  bool two_sided = false;
};
Enclosure find_enclosure(const TouchScene& scene, const Vec3& p_S);

// Warns where a contact begins while the hand is inside a body already, such as in a new session. Where the hand came in is unknown then,
// so the body is felt from within or not at all (docs/faults.md), which looks like a broken system. Warns once, until the hand has been
// outside.
// Frame S. RT: note_start, note_hand, is_watching and is_inside yes; all else set-up only. Threads: one notes; the work is done in a
// thread of its own, and set_scene comes from any.
class InsideBodyWarning {
 public:
  explicit InsideBodyWarning(TouchScene scene);
  ~InsideBodyWarning();
  InsideBodyWarning(const InsideBodyWarning&) = delete;
  InsideBodyWarning& operator=(const InsideBodyWarning&) = delete;

  // Contact begins here.
  void note_start(const Vec3& p_S) noexcept {
    hand_ = {hand_.start + 1, p_S, p_S, false};
    is_watching_.store(true, std::memory_order_release);
    hands_.publish(hand_);
  }
  // Places of the hand are of use until it is out.
  bool is_watching() const noexcept { return is_watching_.load(std::memory_order_acquire); }
  void note_hand(const Vec3& p_S, bool contact) noexcept {
    hand_.p_S = p_S;
    hand_.contact = contact;
    hands_.publish(hand_);
  }
  // Since the last start, as far as known.
  bool is_inside() const noexcept { return is_inside_.load(std::memory_order_acquire); }

  void set_scene(TouchScene scene);

 private:
  struct Hand {
    std::uint64_t start = 0;  // counts them
    Vec3 p_SStart = Vec3::Zero();
    Vec3 p_S = Vec3::Zero();
    bool contact = false;
  };

  void run();
  void check(const Hand& hand);

  std::mutex mutex_;  // of the scene
  TouchScene scene_;
  Mailbox<Hand> hands_;
  Hand hand_;  // the noting thread's
  std::atomic<bool> is_watching_ = false;
  std::atomic<bool> is_inside_ = false;
  std::atomic<bool> stop_ = false;
  std::uint64_t checked_start_ = 0;  // this thread's: the start that it knows
  std::thread thread_;
};

}  // namespace hapton
