#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace hapton {

struct AnnotatorOptions {
  std::filesystem::path file;                 // .toml: read at the start where it exists, written at the end and on a key; empty: none
  std::filesystem::path strokes;              // .obj or .vtp: written with it, for other programs; empty: none
  std::filesystem::path export_folder = ".";  // of what is exported by a key or the menu
  int draw_button = 2;                        // of the stylus, from 1; 0: none
  int measure_button = 3;
  int menu_button = 4;
};

// What the command line alone shows to be wrong. Error: a file name with another ending, or one button for two things. RT: no.
Result<void> check_annotator_options(const AnnotatorOptions& options);

// Error: a file of the options that cannot be written. RT: no.
Result<void> check_writable_files(const AnnotatorOptions& options);

}  // namespace hapton
