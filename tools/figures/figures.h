#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// One figure of docs/methods.md, computed by the methods themselves and drawn by gnuplot.
struct Figure {
  std::string name;    // the picture is NAME.png
  std::string script;  // gnuplot, data and all; draws NAME.png.part in the folder it runs in
};

// All of them, in the order of the text. Nothing in them is random. Error: as make_method.
Result<std::vector<Figure>> make_figures();

}  // namespace hapton
