#include "scene/library_effect.h"

#include <fmt/core.h>

#include "scene/text_cursor.h"

namespace hapton {

LibraryEffect LibraryEffect::located_in(const std::filesystem::path& folder) const {
  LibraryEffect located = *this;
  located.library = (folder / library).lexically_normal();
  if (!located.library.has_parent_path()) located.library = "./" / located.library;
  return located;
}

std::string LibraryEffect::describe() const {
  return fmt::format("line {}: effect {} is the plug-in {}: only haptics_node --allow-plugins runs it", line, printable(name),
                     printable(library.string()));
}

}  // namespace hapton
