// A figure as a script for gnuplot that prints SVG. The layout is computed here, not left to gnuplot, so that it is the
// same everywhere and nothing covers the data.
#pragma once

#include <string>

#include "report/plot.h"

namespace ctn::report {

// Colours and a font name that render_svg finds again in gnuplot's output.
inline constexpr const char* kInkColour = "#1f2328";
inline constexpr const char* kGridColour = "#e4e7ea";
inline constexpr const char* kFontName = "CatanFont";

std::string plot_script(const Figure& figure);

}  // namespace ctn::report
