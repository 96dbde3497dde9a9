#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/force/streamed_method.h"
#include "core/force/touch_scene.h"
#include "link/known_shapes.h"
#include "patch/streamed_parts.h"

namespace hapton {

// The next motion of the surface of a patch, made ready.
struct PatchShape {
  std::unique_ptr<ShapeStage> stage;
  std::uint32_t patch = 0;    // Patch::number
  std::int64_t start_ns = 0;  // scene time, as announced (ShapeStart)
  std::int64_t end_ns = 0;
};

// Makes the patch of a body that programs deform, in the shape that it has, and the stages to the shapes that are announced after it.
//
// A stage begins where the one before ends. A shape that did not come whole, or that the surface cannot take, is left out. Of shapes that
// are over before they were made ready, only the last one counts. Frame: that of the body. RT: no. Threads: one.
class PatchShaper {
 public:
  // The method of another patch, at a scene time. Null: no shape is known for it. Error: the surface cannot be felt.
  Result<std::unique_ptr<StreamedMethod>> make(const MethodSettings& settings, const TouchObject& object, const StreamedParts& parts,
                                               const KnownShapes& shapes, std::int64_t scene_time_ns);
  // The next stage for the patch that was made last; null: there is none.
  std::unique_ptr<PatchShape> make_next(const StreamedParts& parts, const KnownShapes& shapes, std::int64_t scene_time_ns);
  // Of the patch that was made last; they count up.
  std::uint32_t number() const noexcept { return number_; }
  // The patch is used no more.
  void forget() noexcept { stager_.reset(); }

 private:
  std::unique_ptr<ShapeStage> make_stage(const StreamedParts& parts, const KnownShapes& shapes, std::uint32_t serial);

  std::shared_ptr<const ShapeStager> stager_;  // null: there is no patch
  std::vector<Vec3> base_;                     // where the newest stage ends
  std::uint32_t serial_ = 0;                   // of its shape, or of a later one that was left out
  std::uint32_t number_ = 0;
};

}  // namespace hapton
