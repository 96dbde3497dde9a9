#pragma once

#include <filesystem>

namespace hapton {

// Where a scene file is that was named: as it was named, seen from the current folder; where there is none, in the folder that the programs
// were installed with (PREFIX/bin beside PREFIX/share/hapton). What is nowhere stays as it was named. RT: set-up only.
std::filesystem::path find_scene(const std::filesystem::path& named);

// The same with the program's own folder told.
std::filesystem::path find_scene(const std::filesystem::path& named, const std::filesystem::path& program_folder);

}  // namespace hapton
