#include "report_page.h"

#include <filesystem>

#include "page/page.h"

namespace ctn::tool {
namespace {

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

}  // namespace

Result<std::string> report_page(const record::Reader& record, const std::string& path, const std::string& compare,
                                bool all) {
  const auto story = page::tell(record, all);
  if (!story) return story.error();
  const page::ShownRun run{file_name(path), *story};
  if (compare.empty()) return page::to_html(run);
  const auto other = record::Reader::open(compare);
  if (!other) return other.error();
  const auto other_story = page::tell(*other, all);
  if (!other_story) return other_story.error();
  const std::string name = file_name(compare);
  return page::compare_html(run, {name == run.name ? name + " (other)" : name, *other_story});
}

}  // namespace ctn::tool
