#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/force/evaluation/stress_body.h"
#include "core/force/evaluation/stress_episode.h"
#include "core/force/force_method.h"

namespace hapton {

// What went wrong, in steps. All must be zero. Not every fault can be told everywhere: see StressCount::looked_for.
enum class StressFault : std::uint8_t {
  fall,     // no force with the device more than 0.25 % of the extent on the wrong side
  inside,   // the proxy itself on the wrong side of the surface
  through,  // open meshes: from one free place to another straight through a face, away from any border, where the reference does not come
  lock,     // proxy more than 10 % of the extent farther from the device than the surface is, and not at a minimum
  lag,      // proxy not at a minimum: the reference, started there, comes nearer to the device by more than 0.1 % of the extent
  pop,      // convex room: the force changed by more than stiffness times the device's motion
  not_finite,  // NaN or infinite output
  broken,      // force, proxy and contact contradict each other, or a sample that is not finite is felt
  count
};

std::string_view name_of(StressFault fault);
// What it means and where it is looked for: half a line for people.
std::string_view meaning_of(StressFault fault);

// The first fault of a kind, to be found again: body, scale, place, seed, episode and step tell it all.
struct StressFinding {
  StressFault fault = StressFault::fall;
  StressMotion motion = StressMotion::slide;
  std::uint64_t episode = 0;
  std::size_t step = 0;
  double size = 0.0;  // what was too large, as a share of the extent
};

struct StressCount {
  std::uint64_t steps = 0;
  std::uint64_t contact_steps = 0;
  std::uint64_t episodes = 0;
  std::uint64_t judged_rests = 0;  // steps the reference was asked about
  std::array<std::uint64_t, static_cast<std::size_t>(StressFault::count)> faults{};
  std::array<bool, static_cast<std::size_t>(StressFault::count)> looked_for{};  // false: a zero says nothing
  std::vector<StressFinding> findings;                                          // the first few of each fault

  std::uint64_t total_faults() const;
  void add(const StressCount& other);
};

struct StressSettings {
  std::uint64_t seed = 1;
  double scale = 1.0;           // the body is scaled by this
  double offset_extents = 0.0;  // and moved by so many of its extents along (1, -1, 1)
  Material material = {};
  std::size_t rest_every = 64;  // in every how many steps the reference is asked whether the proxy is at rest; 0: only on suspicion
};

// One body in one place, and a method that touches it. An episode begins with a reset on the free side and runs one motion of up to 400
// steps, or a long walk; it depends on nothing but body, settings and its number, so any can be run again alone.
class StressRun {
 public:
  using MethodMaker = std::function<Result<std::unique_ptr<ForceMethod>>(const MethodSettings&, const TouchScene&)>;

  // Error: what the method refuses.
  static Result<StressRun> make(const StressBody& body, const StressSettings& settings, const MethodSettings& method,
                                const MethodMaker& maker = &make_method);

  // Runs an episode to its end and counts. Returns its steps.
  std::size_t run_episode(std::uint64_t episode, StressCount& count);

  ~StressRun();
  StressRun(StressRun&&) noexcept;
  StressRun& operator=(StressRun&&) noexcept;

 private:
  struct Inside;
  explicit StressRun(std::unique_ptr<Inside> inside);
  std::unique_ptr<Inside> inside_;
};

}  // namespace hapton
