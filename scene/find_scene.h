#pragma once

#include <filesystem>

namespace hapton {

// Where a named scene file is: seen from the current folder; else in the folder that the programs were installed with (PREFIX/bin beside
// PREFIX/share/hapton); else in the source tree of programs in build/PRESET/bin. A file that is in none of them keeps its name. RT: no.
std::filesystem::path find_scene(const std::filesystem::path& named);

// The same with the program's own folder given.
std::filesystem::path find_scene(const std::filesystem::path& named, const std::filesystem::path& program_folder);

}  // namespace hapton
