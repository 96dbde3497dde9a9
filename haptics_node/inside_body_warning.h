#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/touch_scene.h"

namespace hapton {

// Whether a point is inside a body of the scene: enclosed by faces that point outwards. Objects that move by keyframes or by programs are
// left out, and so are bodies with more than small holes. two_sided: the body is felt from within; a body that can be carved never is.
// Searches all triangles of the bodies whose box holds the point: 0.1 s for a million triangles. Frame S. RT: no.
struct Enclosure {
  bool is_inside = false;
  bool two_sided = false;
};
Enclosure find_enclosure(const TouchScene& scene, const Vec3& p_S);

// Warns if the probe or tool starts at the device point while that is inside a body, for example in a new session. Then it is unknown where
// the hand entered the body, so the body is felt from within or not at all (docs/faults.md), which looks like a broken system. Warns once,
// and again only after the hand has been outside.
// Frame S. RT: note_start, note_hand, is_watching and is_inside yes; set_scene no; the rest set-up only. Threads: one calls note_start and
// note_hand; any call set_scene, is_watching and is_inside; the search is done in a thread of its own.
class InsideBodyWarning {
 public:
  explicit InsideBodyWarning(TouchScene scene);
  ~InsideBodyWarning();
  InsideBodyWarning(const InsideBodyWarning&) = delete;
  InsideBodyWarning& operator=(const InsideBodyWarning&) = delete;

  // To be called when the probe or tool starts at the device point (HapticsStep::free_starts).
  void note_start(const Vec3& p_S) noexcept {
    hand_ = {hand_.start + 1, p_S, p_S, false};
    is_watching_.store(true, std::memory_order_release);
    hands_.publish(hand_);
  }
  // Whether note_hand() is to be called after each reply: until it is known that the hand is outside.
  bool is_watching() const noexcept { return is_watching_.load(std::memory_order_acquire); }
  void note_hand(const Vec3& p_S, bool contact) noexcept {
    hand_.p_S = p_S;
    hand_.contact = contact;
    hands_.publish(hand_);
  }
  // Whether the hand was inside a body at the last note_start() and has not left it since, by the newest check.
  bool is_inside() const noexcept { return is_inside_.load(std::memory_order_acquire); }

  void set_scene(TouchScene scene);

 private:
  struct Hand {
    std::uint64_t start = 0;  // counts calls of note_start()
    Vec3 p_SStart = Vec3::Zero();
    Vec3 p_S = Vec3::Zero();
    bool contact = false;
  };

  void run();
  void check(const Hand& hand);

  std::mutex mutex_;  // guards scene_
  TouchScene scene_;
  Mailbox<Hand> hands_;
  Hand hand_;  // used by the thread that calls note_start() and note_hand()
  std::atomic<bool> is_watching_ = false;
  std::atomic<bool> is_inside_ = false;
  std::atomic<bool> stop_ = false;
  std::uint64_t checked_start_ = 0;  // Hand::start of the last check; used by this object's own thread
  std::thread thread_;
};

}  // namespace hapton
