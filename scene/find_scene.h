#pragma once

#include <filesystem>

namespace hapton {

// Finds a scene file: relative to the current folder; else in PREFIX/share/hapton if this program is installed in PREFIX/bin; else in the
// source tree if it is in build/PRESET/bin. If the file is in none of them, returns the given name. RT: no.
std::filesystem::path find_scene(const std::filesystem::path& name);

// The same with the program's own folder given.
std::filesystem::path find_scene(const std::filesystem::path& name, const std::filesystem::path& program_folder);

}  // namespace hapton
