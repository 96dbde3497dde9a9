#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// One figure of docs/methods.md, computed by the methods themselves and drawn by gnuplot.
struct Figure {
  std::string name;    // the picture is NAME.png
  std::string script;  // a gnuplot script with its data, which writes NAME.png.part into its working directory
};

// All figures, in the order of the text, always with the same data. Error: that of make_method. RT: no.
Result<std::vector<Figure>> make_figures();

}  // namespace hapton
