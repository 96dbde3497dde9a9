#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace hapton {

struct AnnotatorOptions {
  std::filesystem::path file;                 // .toml: read at the start if it exists, written at the end and on a key; empty: none
  std::filesystem::path strokes;              // .obj or .vtp: written together with `file`, for other programs; empty: none
  std::filesystem::path export_folder = ".";  // folder for what a key or the menu exports
  int draw_button = 2;                        // number of a button of the stylus, from 1; 0: none. The next two as well
  int measure_button = 3;
  int menu_button = 4;
};

// Checks what can be checked without reading files. Error: a file name with another ending, or one button for two functions. RT: no.
Result<void> check_annotator_options(const AnnotatorOptions& options);

// Checks that the files can be written. Error: one that cannot. RT: no.
Result<void> check_writable_files(const AnnotatorOptions& options);

}  // namespace hapton
