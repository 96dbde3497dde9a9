#pragma once

#include <string>
#include <vector>

namespace hapton::structure {

struct Include {
  std::string path;
  bool quoted = false;  // "..." rather than <...>
  int line = 0;
};

// One source file of the tree, read for checking.
struct SourceFile {
  std::string path;               // from the repository root
  std::vector<Include> includes;  // in the order of the file
  std::string code;               // without comments and literals
};

// Every .h and .cpp under a folder of the repository root, sorted by path; empty if there is no such folder.
std::vector<SourceFile> read_folder(const std::string& folder);

// Reads one file's text (the part of read_folder that can be tested alone).
SourceFile read_source(const std::string& path, const std::string& text);

bool exists(const std::string& path);

}  // namespace hapton::structure
