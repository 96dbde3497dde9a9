#include "tools/session/recorded_shapes.h"

#include <utility>

namespace hapton {

void RecordedShapes::add(std::uint64_t sender, const ObjectShape& shape) {
  Sender& own = senders_[sender];
  // Sent again for a picture.
  if (shape.serial <= own.applied) return;
  own.shapes.try_emplace(shape.serial, shape.part.total).first->second.add(shape.part);
}

void RecordedShapes::add(std::uint64_t sender, const ShapeStart& start) {
  Sender& own = senders_[sender];
  if (start.serial > own.applied) own.starts[start.serial] = start;
}

bool RecordedShapes::apply(std::uint64_t sender, std::uint32_t serial, HapticsStep& step,
                           const std::function<std::shared_ptr<const ProgramShape>(std::int32_t object)>& find_shape) {
  Sender& own = senders_[sender];
  const auto shape = own.shapes.extract(serial);
  const auto start = own.starts.extract(serial);
  own.applied = serial;
  if (shape.empty() || start.empty() || !shape.mapped().is_whole()) return false;
  const ShapeStart& begins = start.mapped();
  StreamedMethod* method = step.touch().find_streamed(begins.object);
  const auto program_shape = find_shape(begins.object);
  if (method == nullptr || program_shape == nullptr || method->has_waiting()) return false;
  const ShapeStager& stager = method->stager();
  if (stager.rest().size() != shape.mapped().total()) return false;
  auto stage = stager.make(method->present().to, program_shape->vertices_of(stager.rest(), shape.mapped().displacements_m()));
  if (!stage) return false;
  (void)step.deform(begins.object, std::move(*stage), begins.start_ns, begins.end_ns);
  return true;
}

}  // namespace hapton
