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

// The next motion of the surface of a patch, ready for the device loop.
struct PatchShape {
  std::unique_ptr<ShapeStage> stage;
  std::uint32_t patch = 0;    // Patch::number
  std::int64_t start_ns = 0;  // scene time, as announced (ShapeStart)
  std::int64_t end_ns = 0;
};

// Makes the method of a patch of a body that programs deform, in its present shape, and the stages to the shapes announced after that.
//
// A stage begins where the stage before it ends. A shape that did not come whole, or that the surface cannot take, is left out. If several
// shapes are over before they were made ready, only the last of them is made. Frame: that of the body. RT: no. Threads: one.
class PatchShaper {
 public:
  // Makes the method of a new patch, at a scene time. Null: no shape is known for that time. Error: the surface cannot be felt.
  Result<std::unique_ptr<StreamedMethod>> make(const MethodSettings& settings, const TouchObject& object, const StreamedParts& parts,
                                               const KnownShapes& shapes, std::int64_t scene_time_ns);
  // Makes the next stage for the patch that was made last; null: there is none, or the surface cannot take it.
  std::unique_ptr<PatchShape> make_next(const StreamedParts& parts, const KnownShapes& shapes, std::int64_t scene_time_ns);
  // The number of the patch that was made last; numbers count up.
  std::uint32_t number() const noexcept { return number_; }
  // To call when the patch is no longer used: no stages are made for it.
  void forget() noexcept { stager_.reset(); }

 private:
  std::unique_ptr<ShapeStage> make_stage(const StreamedParts& parts, const KnownShapes& shapes, std::uint32_t serial);

  std::shared_ptr<const ShapeStager> stager_;  // null: there is no patch
  std::vector<Vec3> base_vertices_;            // where the newest stage ends
  std::uint32_t serial_ = 0;                   // serial of that shape, or of a later one that was left out
  std::uint32_t number_ = 0;
};

}  // namespace hapton
