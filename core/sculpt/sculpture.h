#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/sculpt/carve_list.h"
#include "core/sculpt/carved_field.h"
#include "core/sculpt/sculpt_settings.h"

namespace hapton {

// The bodies of a scene, that is, its objects that can be carved, in their present shape. They outlive the force method, which may be
// exchanged. Frame: S. Units: SI. RT: yes, except add. Threads: one at a time.
class Sculpture {
 public:
  // The haptics node keeps all carves for vision nodes, 44 MB: half an hour of carving without a pause, 500 a second (decision 161).
  static constexpr std::uint32_t kMaxCarves = CarveList::kMax;

  struct Body {
    int object = -1;  // number in the scene
    SculptSettings settings;
    CarvedField field;
    std::uint64_t rest_hash = 0;  // hash of the field before any carve
  };

  // Adds a body. object: its number in the scene. Error: that of CarvedField::make. RT: set-up only.
  Result<void> add(int object, const SculptSettings& settings, const TriangleMesh& mesh);

  const std::vector<Body>& bodies() const noexcept { return bodies_; }
  // Field of bodies()[body], to be changed without carve(): only for a copy of these bodies, which a slow task carves.
  CarvedField& field(std::size_t body) noexcept { return bodies_[body].field; }
  // Serial of the newest entry: a carve, or an undo (exchange_shapes); 0: none yet.
  std::uint32_t newest() const noexcept { return newest_; }
  // No further carve or undo is possible.
  bool is_full() const noexcept { return newest_ >= kMaxCarves; }

  // Whether both had the same bodies before any carve, so that one can be used in place of the other.
  bool is_alike(const Sculpture& other) const noexcept;

  // Begins a step: there is no carve in it yet.
  void begin_step() noexcept { carve_of_step_.reset(); }
  // Notes the buttons that are down in this step. pressable: those that carve; the first carve after one of them goes down begins a press.
  void note_buttons(std::uint32_t buttons, std::uint32_t pressable) noexcept {
    has_new_press_ = has_new_press_ || (buttons & pressable & ~last_buttons_) != 0;
    last_buttons_ = buttons;
  }
  // Carves the body with that number in bodies(), unless nothing would change. Pre: !is_full(), !made(): a step has one carve.
  void carve(std::size_t body, const Carve& carve) noexcept;
  // Exchanges the shapes of these bodies with those of `other`, in which carves were undone. newest: the serial of that undo. Pre:
  // is_alike(other).
  void exchange_shapes(Sculpture& other, std::uint32_t newest) noexcept;
  // The carve of this step, if there was one.
  const std::optional<MadeCarve>& made() const noexcept { return carve_of_step_; }

 private:
  std::vector<Body> bodies_;
  std::uint32_t newest_ = 0;
  std::optional<MadeCarve> carve_of_step_;
  std::uint32_t last_buttons_ = 0;
  bool has_new_press_ = false;  // a button was pressed, and nothing was carved since
};

}  // namespace hapton
