#include "base/result.h"

#include <fmt/format.h>

namespace ctn {

std::string to_string(const Problem& problem) {
  std::string text = problem.place.file;
  if (problem.place.line > 0) {
    text += fmt::format("{}{}", text.empty() ? "line " : ":", problem.place.line);
    if (problem.place.column > 0) text += fmt::format(":{}", problem.place.column);
  }
  if (!text.empty()) text += ": ";
  if (!problem.key.empty()) text += problem.key + ": ";
  text += problem.what;
  if (!problem.hint.empty()) text += "; " + problem.hint;
  return text;
}

std::string Error::message() const {
  std::string text;
  for (const Problem& problem : problems_) {
    if (!text.empty()) text += '\n';
    text += to_string(problem);
  }
  return text;
}

}  // namespace ctn
