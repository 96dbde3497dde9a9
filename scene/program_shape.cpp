#include "scene/program_shape.h"

#include "scene/object_reader.h"
#include "scene/scene_loading.h"
#include "scene/text_cursor.h"

namespace hapton {

Result<std::shared_ptr<const ProgramShape>> make_program_shape(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                               const TriangleMesh& mesh, const SealReport& sealed) {
  if (!object.program_shape.is_on) return std::shared_ptr<const ProgramShape>();
  const std::size_t line = object.program_shape.line;
  if (sealed.has_sealed()) {
    return fail("line {}: programs deform '{}', and cracks of it were sealed: add seal_cracks = false, or repair it", line,
                printable(name));
  }
  if (mesh.vertices.size() > ProgramShape::kMaxVertices) {
    return fail("line {}: programs deform '{}', which has {} vertices: at most {}", line, printable(name), mesh.vertices.size(),
                ProgramShape::kMaxVertices);
  }
  const double scale = fit.scale * object.scale;
  return std::make_shared<const ProgramShape>(
      ProgramShape{.reach_m = scale * object.program_shape.reach_m, .to_scene = scale * object.q_SM.toRotationMatrix()});
}

}  // namespace hapton
