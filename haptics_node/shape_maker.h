#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/streamed_method.h"
#include "link/messages.h"
#include "scene/program_shape.h"

namespace hapton {

// A shape that a program wants an object to take.
struct WantedShape {
  std::uint32_t stream = 0;  // this and the next two: as in ShapeRequest
  std::uint32_t shape = 0;
  double over_s = 0.0;
  std::vector<ShapePart::Displacement> displacements_m = {};  // one for each vertex of the mesh
};

// A wanted shape that is ready to be felt.
struct MadeShape {
  WantedShape wanted;
  std::unique_ptr<ShapeStage> stage;
};

struct RejectedShape {  // a shape that the surface cannot take, and why
  std::uint32_t stream = 0;
  std::uint32_t shape = 0;
  HapticsSetup::Text why = {};
};

// Makes shapes of one object ready, in another thread than the loop that replies to the device: the loop passes in the newest shape, and
// takes the finished stage when the surface may start to move to it. A finished stage that is not taken yet is replaced by a newer one.
// Each stage begins where the stage that was taken before it ends.
//
// RT: draft, publish, take, give_back and take_rejection yes; the rest set-up only. Threads: one for these five, another one for work().
class ShapeMaker {
 public:
  // Pre: the method outlives this, and has had no stage yet.
  ShapeMaker(const StreamedMethod& method, const ProgramShape& shape);
  ~ShapeMaker();
  ShapeMaker(const ShapeMaker&) = delete;
  ShapeMaker& operator=(const ShapeMaker&) = delete;

  // A shape to be filled in, without changing the number of displacements, and then published; a newer one replaces it.
  WantedShape& draft() noexcept { return wanted_.draft(); }
  void publish() noexcept { wanted_.publish_draft(); }

  // The newest shape that is ready; null: none, or the last one given back is not destroyed yet. The surface must move to the result.
  std::unique_ptr<MadeShape> take() noexcept;
  // Returns a shape that is no longer used; work() destroys it. Pre: at most once between two calls of take() that give something.
  void give_back(std::unique_ptr<MadeShape> made) noexcept { retired_.store(made.release(), std::memory_order_release); }
  // The newest shape that the surface cannot take; each is returned once. Null: there is no new one.
  const RejectedShape* take_rejection() noexcept { return rejections_.take() ? &rejections_.value() : nullptr; }

  // Makes the newest shape ready; false: there is none. Work: as ShapeStager::make. RT: no.
  bool work();

 private:
  void note_taken() noexcept;
  void reject(const std::string& why);

  const ShapeStager& stager_;
  const ProgramShape shape_;
  Mailbox<WantedShape> wanted_;
  Mailbox<RejectedShape> rejections_;
  std::atomic<MadeShape*> made_ = nullptr;
  std::atomic<MadeShape*> retired_ = nullptr;
  // Used by work() only:
  std::vector<Vec3> next_start_;   // vertices where the stage taken last ends
  MadeShape* offered_ = nullptr;   // last put into made_; not to be dereferenced, as the loop may have taken it
  std::vector<Vec3> offered_end_;  // vertices where its stage ends
  bool is_pending_ = false;        // wanted_.value() is not ready yet
};

}  // namespace hapton
