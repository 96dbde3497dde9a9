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
  std::uint32_t stream = 0;  // these as in ShapeRequest
  std::uint32_t shape = 0;
  double over_s = 0.0;
  std::vector<ShapePart::Displacement> displacements_m = {};  // by vertex of the mesh
};

// ... ready to be felt.
struct MadeShape {
  WantedShape wanted;
  std::unique_ptr<ShapeStage> stage;
};

struct RejectedShape {
  std::uint32_t stream = 0;
  std::uint32_t shape = 0;
  HapticsSetup::Text why = {};
};

// Makes shapes of one object ready, beside the loop that replies to the device: the loop passes in the newest shape, and takes the
// finished stage when the surface may start to move towards it. Until it is taken, a newer one takes its place. A stage begins where the
// one that was taken before ends.
//
// RT: draft, publish, take, give_back and take_rejection yes; the rest set-up only. Threads: these one, work() another.
class ShapeMaker {
 public:
  // Pre: the method outlives this, and has had no stage yet.
  ShapeMaker(const StreamedMethod& method, const ProgramShape& shape);
  ~ShapeMaker();
  ShapeMaker(const ShapeMaker&) = delete;
  ShapeMaker& operator=(const ShapeMaker&) = delete;

  // To be filled, without changing the number of displacements, and published: the newest counts.
  WantedShape& draft() noexcept { return wanted_.draft(); }
  void publish() noexcept { wanted_.publish_draft(); }

  // The newest that is ready; null: none, or what was given back last still waits to be destroyed. The surface has to take it.
  std::unique_ptr<MadeShape> take() noexcept;
  // Returns a shape that is no longer used; work() destroys it. Pre: at most once between two calls of take() that give something.
  void give_back(std::unique_ptr<MadeShape> made) noexcept { retired_.store(made.release(), std::memory_order_release); }
  // The newest that the surface cannot take, once; null: none.
  const RejectedShape* take_rejection() noexcept { return rejections_.take() ? &rejections_.value() : nullptr; }

  // Makes the newest ready; false: there is none. Work: as ShapeStager::make.
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
  // Of work():
  std::vector<Vec3> base_;        // where the stage ends that was taken last
  MadeShape* offered_ = nullptr;  // in made_, or taken since: not to be followed
  std::vector<Vec3> offered_to_;  // where it ends
  bool is_pending_ = false;       // wanted_.value() is not ready yet
};

}  // namespace hapton
