#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <thread>

#include "link/messages.h"
#include "runtime/mailbox.h"

namespace hapton {

// What one loop holds.
struct StiffnessAdvice {
  double safe_n_per_m = 0.0;  // recommend_stiffness, the least over the hands and the devices it can be
  std::string device;         // title of that device
  std::string hand;
  bool is_limited_by_device = false;  // no more is known of it, whatever the hand and the delay
};
// Nothing where no model of the device is known, or the facts are empty. RT: no, some 0.1 s.
std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts);

// Warns when a scene asks for more stiffness than the measured loop holds: once, and again when the loop has become much slower.
// RT: note yes; making one is set-up only. Threads: note one; the work is done in a thread of its own.
class StiffnessAdviser {
 public:
  static constexpr double kMuchSlower = 1.25;  // round trip, over that of the last advice

  // stiffest_n_per_m: of the scene.
  explicit StiffnessAdviser(double stiffest_n_per_m);
  ~StiffnessAdviser();
  StiffnessAdviser(const StiffnessAdviser&) = delete;
  StiffnessAdviser& operator=(const StiffnessAdviser&) = delete;

  void note(const LoopFacts& facts) noexcept { facts_.publish(facts); }
  // The scene's materials have changed. Threads: any.
  void set_stiffest(double stiffest_n_per_m) noexcept { stiffest_n_per_m_.store(stiffest_n_per_m, std::memory_order_release); }

 private:
  void run();
  void consider(const LoopFacts& facts);
  void advise(const LoopFacts& facts, double stiffest_n_per_m);

  std::atomic<double> stiffest_n_per_m_;
  Mailbox<LoopFacts> facts_;
  LoopFacts considered_;             // this thread's own
  double considered_n_per_m_ = 0.0;  // likewise
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
