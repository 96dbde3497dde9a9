#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/sculpt/carved_field.h"
#include "core/sculpt/sculpt_settings.h"

namespace hapton {

// A carve that was made, for every process that keeps the same fields.
struct MadeCarve {
  int object = -1;           // number in the scene
  std::uint32_t serial = 0;  // counts the carves of all objects, from 1
  Carve carve;               // rounded()
};

// The bodies of a scene, that is, its objects that can be carved, in their present shape. They outlive the force method, which may be
// exchanged. Frame: S. Units: SI. RT: yes, except add. Threads: one at a time.
class Sculpture {
 public:
  // The haptics node keeps all carves for vision nodes, 32 MB: half an hour of carving without a pause, 500 a second (decision 161).
  static constexpr std::uint32_t kMostCarves = 1'000'000;

  struct Body {
    int object = -1;  // number in the scene
    SculptSettings settings;
    CarvedField field;
    std::uint64_t rest_hash = 0;  // hash of the field before any carve
  };

  // Adds a body. object: its number in the scene. Error: that of CarvedField::make. RT: set-up only.
  Result<void> add(int object, const SculptSettings& settings, const TriangleMesh& mesh);

  const std::vector<Body>& bodies() const noexcept { return bodies_; }
  // Serial of the newest carve; 0: none yet.
  std::uint32_t newest() const noexcept { return newest_; }
  // No further carve is possible.
  bool is_full() const noexcept { return newest_ >= kMostCarves; }

  // Whether both had the same bodies before any carve, so that one can be used in place of the other.
  bool is_alike(const Sculpture& other) const noexcept;

  // Begins a step: there is no carve in it yet.
  void begin_step() noexcept { made_.reset(); }
  // Carves the body with that number in bodies(), unless nothing would change. Pre: !is_full(), !made(): a step has one carve.
  void carve(std::size_t body, const Carve& carve) noexcept;
  // The carve of this step, if there was one.
  const std::optional<MadeCarve>& made() const noexcept { return made_; }

 private:
  std::vector<Body> bodies_;
  std::uint32_t newest_ = 0;
  std::optional<MadeCarve> made_;
};

}  // namespace hapton
