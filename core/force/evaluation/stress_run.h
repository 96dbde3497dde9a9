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

// The kinds of fault, counted in steps. All counts must be zero. Body and material decide which are tested: see StressCount::covered.
enum class StressFault : std::uint8_t { fall_through, inside, through, stuck, unconverged, discontinuity, not_finite, broken, count };

std::string_view name_of(StressFault fault);
// What the fault means and for which bodies it is tested: a phrase for messages.
std::string_view meaning_of(StressFault fault);

// A step with a fault. Method, body, settings and episode reproduce it.
struct StressFinding {
  StressFault fault = StressFault::fall_through;
  StressMotion motion = StressMotion::slide;
  std::uint64_t episode = 0;
  std::size_t step = 0;
  double size = 0.0;  // size of the error as a share of the extent; 0: it has none
};

struct StressCount {
  std::uint64_t steps = 0;
  std::uint64_t contact_steps = 0;
  std::uint64_t episodes = 0;
  std::uint64_t compared_steps = 0;  // steps compared with the reference
  std::uint64_t carried_steps = 0;   // work used up: repeated with the same sample until finished (1024 times at most), then judged
  std::array<std::uint64_t, static_cast<std::size_t>(StressFault::count)> faults{};
  std::array<bool, static_cast<std::size_t>(StressFault::count)> covered{};  // false: not tested, so a zero says nothing
  std::vector<StressFinding> findings;                                       // the first of each fault in each motion; add() appends

  std::uint64_t total_faults() const;
  void add(const StressCount& other);
};

struct StressSettings {
  std::uint64_t seed = 1;
  double scale = 1.0;           // scale of the body
  double offset_extents = 0.0;  // the body is moved by this many extents times (1, -1, 1)
  Material material = {};
  std::size_t compare_every = 64;  // compares with the reference each n-th step and those with an extension above 10 %; 0: only these
};

// One body at one position, and the method under test. An episode begins with a reset on the free side and runs one motion of up to 400
// steps, or a long walk. It depends on method, body, settings and its number only, so each can be repeated alone. RT: no.
class StressRun {
 public:
  using MethodMaker = std::function<Result<std::unique_ptr<ForceMethod>>(const MethodSettings&, const TouchScene&)>;

  // Error: a body without triangles; whatever maker or the reference rejects.
  static Result<StressRun> make(const StressBody& body, const StressSettings& settings, const MethodSettings& method,
                                const MethodMaker& maker = &make_method);

  // Runs one episode and counts its faults. Returns the number of steps; 0: no free position to begin at was found.
  std::size_t run_episode(std::uint64_t episode, StressCount& count);

  ~StressRun();
  StressRun(StressRun&&) noexcept;
  StressRun& operator=(StressRun&&) noexcept;

 private:
  struct Impl;
  explicit StressRun(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace hapton
