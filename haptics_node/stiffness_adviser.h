#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <thread>

#include "link/messages.h"
#include "runtime/mailbox.h"

namespace hapton {

// The largest stiffness that a loop of hand, device and delay renders stably.
struct StiffnessAdvice {
  double safe_n_per_m = 0.0;          // recommend_stiffness, the least over all hands and all devices with this name
  std::string device;                 // title of the device with the least
  std::string hand;                   // name of the hand with the least
  bool is_limited_by_device = false;  // the device's own stiffness limit is the least, whatever hand and delay
};
// None: no model of the device is known, or the facts are empty. RT: no; takes about 0.1 s.
std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts);

// Logs a warning if a scene has a larger stiffness than the measured loop renders stably: once, and again for another loop, a stiffer
// scene, or a round trip that has become longer by kMuchSlower. RT: note and set_stiffest yes; construction and destruction set-up only.
// Threads: one calls note; a thread of its own computes.
class StiffnessAdviser {
 public:
  static constexpr double kMuchSlower = 1.25;  // round trip over that of the last warning; less would repeat it for every fluctuation

  // stiffest_n_per_m: the largest stiffness of the scene.
  explicit StiffnessAdviser(double stiffest_n_per_m);
  ~StiffnessAdviser();
  StiffnessAdviser(const StiffnessAdviser&) = delete;
  StiffnessAdviser& operator=(const StiffnessAdviser&) = delete;

  void note(const LoopFacts& facts) noexcept { facts_.publish(facts); }
  // The materials of the scene have changed. Threads: any.
  void set_stiffest(double stiffest_n_per_m) noexcept { stiffest_n_per_m_.store(stiffest_n_per_m, std::memory_order_release); }

 private:
  void run();
  void consider(const LoopFacts& facts);
  void advise(const LoopFacts& facts, double stiffest_n_per_m);

  std::atomic<double> stiffest_n_per_m_;
  Mailbox<LoopFacts> facts_;
  LoopFacts considered_;             // of the last advice; used by its own thread alone
  double considered_n_per_m_ = 0.0;  // the stiffness then; the same
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
