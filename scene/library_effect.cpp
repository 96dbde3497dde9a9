#include "scene/library_effect.h"

#include <fmt/core.h>

#include "scene/text_cursor.h"

namespace hapton {

std::string LibraryEffect::describe() const {
  return fmt::format("line {}: effect {} is the plug-in {}: only haptics_node --allow-plugins runs it", line, printable(name),
                     printable(library.string()));
}

}  // namespace hapton
