#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/sculpt/carved_field.h"
#include "core/sculpt/sculpt_settings.h"

namespace hapton {

// A carve that was made, for all who keep the same field.
struct MadeCarve {
  int object = -1;           // of the scene
  std::uint32_t serial = 0;  // counts the carves of all objects, from 1
  Carve carve;               // rounded
};

// The bodies of material of a scene in their present shape: what outlives the method that feels them. RT: carve yes. Threads: one at a
// time.
class Sculpture {
 public:
  // No more can be kept by those who show and record them: half an hour of carving without pause.
  static constexpr std::uint32_t kMostCarves = 1'000'000;

  struct Body {
    int object = -1;  // of the scene
    SculptSettings settings;
    CarvedField field;
    std::uint64_t rest_hash = 0;  // of the field before any carve
  };

  // Error: that of CarvedField::make. RT: set-up only.
  Result<void> add(int object, const SculptSettings& settings, const TriangleMesh& mesh);

  const std::vector<Body>& bodies() const noexcept { return bodies_; }
  // The newest serial; 0: none yet.
  std::uint32_t newest() const noexcept { return newest_; }
  bool is_full() const noexcept { return newest_ >= kMostCarves; }

  // The same bodies at rest: one can go on in place of the other.
  bool is_alike(const Sculpture& other) const noexcept;

  // Carves the body with that number, if it changes there. At most one a step; begin_step() before. Pre: !is_full(), !made().
  void begin_step() noexcept { made_.reset(); }
  void carve(std::size_t body, const Carve& carve) noexcept;
  // Of this step.
  const std::optional<MadeCarve>& made() const noexcept { return made_; }

 private:
  std::vector<Body> bodies_;
  std::uint32_t newest_ = 0;
  std::optional<MadeCarve> made_;
};

}  // namespace hapton
