#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// Checks that a folder can be written to or made, or that a file can be written or replaced (PartPath); also that the names are not too
// long. A folder that a link points to must exist, because none can be made through a link. Leaves nothing behind. For programs that write
// their results at the end and should fail at the start. Error: one line with the path, the reason and what to do. RT: no.
Result<void> check_writable_folder(const std::filesystem::path& folder);
Result<void> check_writable_file(const std::filesystem::path& file);

// Whether two names lead to the same file, also through links and if it does not exist yet, so that the output written last would replace
// the other. False if one is a device or a pipe, which takes both outputs, or an empty name, which names no output. RT: no.
bool is_same_output(const std::filesystem::path& a, const std::filesystem::path& b);

// An output of a command, and the flag that names it.
struct NamedOutput {
  const char* flag;
  std::filesystem::path file;
};
// Error: one line with the flags of two outputs that are the same file. RT: no.
Result<void> check_different_outputs(const std::vector<NamedOutput>& outputs);

}  // namespace hapton
