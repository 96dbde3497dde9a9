#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace hapton {

// An [[effect]] of type "plugin": a shared library that the scene file names (docs/plugins.md). Reading a scene only reads the
// name; only haptics_node --allow-plugins loads the library, which runs its code.
struct LibraryEffect {
  std::string name;               // default: the library's file name
  std::filesystem::path library;  // relative ones start at the scene file's folder
  std::vector<std::pair<std::string, std::string>> parameters = {};
  std::size_t line = 0;  // in the scene file

  // Whether both load the same library with the same parameters, independent of their lines in the file.
  bool same_as(const LibraryEffect& other) const { return library == other.library && parameters == other.parameters; }
  // The same effect with the library's path taken from this folder. It has a slash, so that the loader searches nowhere else.
  LibraryEffect located_in(const std::filesystem::path& folder) const;
  // One line for users, which says that only haptics_node --allow-plugins runs the library.
  std::string describe() const;
};

}  // namespace hapton
