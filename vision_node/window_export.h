#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"
#include "vision_node/carved_objects.h"

namespace hapton {

// A person's work as it is in the picture.
struct WindowWork {
  const Scene& scene;
  const Annotations& placed;  // strokes and measures in the present shape of their objects
  const ObjectPoses& X_SO;
  const CarvedObjects* carved = nullptr;  // null: nothing is carved
};

// Writes it for other programs, under the next free number: strokes and measures as hapton_export_001.vtp, the surface of each object that
// is carved as hapton_export_001_NAME.stl, S, metres. Each file is there as a whole or not at all. Returned: a line for the picture that
// says where the files are, or that there is nothing to write. Error: one line. RT: no.
Result<std::string> export_work(const WindowWork& work, const std::filesystem::path& folder);

}  // namespace hapton
