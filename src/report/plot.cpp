#include "report/plot.h"

#include <fmt/format.h>
#include <stdio.h>  // popen, fileno: POSIX

#include <cassert>
#include <functional>
#include <memory>

#include "report/escape.h"
#include "report/plot_script.h"

namespace ctn::report {
namespace {

struct CloseFile {
  void operator()(FILE* file) const { fclose(file); }
};
using File = std::unique_ptr<FILE, CloseFile>;

const char* const kHint = "install it: apt-get install gnuplot-nox";

const char* const kFonts =
    "font-family=\"Inter, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, 'Liberation Sans', sans-serif\"";

std::string read_all(FILE* file) {
  std::string text;
  char buffer[1 << 14];
  while (const std::size_t size = fread(buffer, 1, sizeof buffer, file)) text.append(buffer, size);
  return text;
}

// The script reaches gnuplot as an open file without a name, so nothing is left behind whatever happens, and a gnuplot
// that dies early cannot break a pipe that we write to. Only its number is put into the command.
Result<std::string> run_gnuplot(const std::string& script) {
  const File input(tmpfile());
  const File errors(tmpfile());
  if (!input || !errors || fwrite(script.data(), 1, script.size(), input.get()) != script.size() ||
      fflush(input.get()) != 0) {
    return Error::environment("no temporary file can be written for gnuplot", "make room in the temporary folder");
  }
  const std::string command =
      fmt::format("exec gnuplot -d /dev/fd/{} 2>/dev/fd/{}", fileno(input.get()), fileno(errors.get()));
  FILE* output = popen(command.c_str(), "r");
  if (output == nullptr) return Error::environment("gnuplot, which draws the plots, cannot be run", kHint);
  std::string svg = read_all(output);
  const int status = pclose(output);
  if (status == 127 << 8) return Error::environment("gnuplot, which draws the plots, is not installed", kHint);
  if (status == 0 && svg.find("</svg>") != std::string::npos) return svg;
  rewind(errors.get());
  return Error::environment("gnuplot failed to draw a plot: " + read_all(errors.get()),
                            "check that `gnuplot --version` says 5.2 or newer");
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// gnuplot titles each group with the expression it was drawn from, which browsers show as a tooltip.
void erase_titles(std::string& svg) {
  constexpr std::string_view kStart = "<title>$";
  constexpr std::string_view kEnd = "</title>";
  for (std::size_t at = svg.find(kStart); at != std::string::npos; at = svg.find(kStart, at)) {
    const std::size_t end = svg.find(kEnd, at);
    if (end == std::string::npos) return;
    svg.erase(at, end + kEnd.size() - at);
  }
}

// Several figures of one page must not share ids.
std::string unique_prefix(const std::string& script) {
  return fmt::format("f{:x}-", std::hash<std::string>{}(script)&0xffffffffU);
}

std::string finish(std::string svg, const Figure& figure, const std::string& script, SvgUse use) {
  const std::string prefix = unique_prefix(script);
  for (const char* quote : {"'", "\""}) {
    replace_all(svg, fmt::format(" id={}", quote), fmt::format(" id={}{}", quote, prefix));
    replace_all(svg, fmt::format("xlink:href={}#", quote), fmt::format("xlink:href={}#{}", quote, prefix));
  }
  replace_all(svg, "url(#", "url(#" + prefix);
  replace_all(svg, fmt::format("font-family=\"{}:Bold\"", kFontName), fmt::format("font-weight=\"600\" {}", kFonts));
  replace_all(svg, fmt::format("font-family=\"{}\"", kFontName), kFonts);
  replace_all(svg, "color='white'", "display='none'");  // a halo around points, which shows on any other ground
  erase_titles(svg);
  replace_all(svg, "<title>Gnuplot</title>", "<title>" + escaped(figure.title) + "</title>");
  if (use == SvgUse::kInline) {
    replace_all(svg, "stroke='rgb(228, 231, 234)'", "stroke='currentColor' stroke-opacity='0.14'");  // kGridColour
    for (const char* ink : {"rgb(31,35,40)", "rgb( 31,  35,  40)"})
      replace_all(svg, ink, "currentColor");  // kInkColour
    replace_all(svg, "color=\"black\"", "color=\"currentColor\"");
    svg.erase(0, svg.find("<svg"));
    return svg.insert(4, " role=\"img\"");
  }
  const std::size_t body = svg.find('>', svg.find("<svg")) + 1;
  return svg.insert(body, "\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>");
}

}  // namespace

Result<std::string> render_svg(const Figure& figure, SvgUse use) {
  assert(!figure.panels.empty() && figure.width > 0 && figure.panel_height > 0);
  const std::string script = plot_script(figure);
  auto svg = run_gnuplot(script);
  if (!svg) return svg;
  return finish(std::move(*svg), figure, script, use);
}

}  // namespace ctn::report
