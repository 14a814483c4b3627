#include "look.h"

#include "page/story.h"
#include "record/reader.h"

namespace ctn::demo {
namespace {

constexpr double kSeconds = 5.0;  // at slowdown 1
constexpr double kQuickSeconds = 2.0;

}  // namespace

std::array<Trial, 2> looked_at(const Setting& setting) {
  Trial trial;
  if (!setting.cpu_sets.empty()) trial.cpus = setting.cpu_sets.back();
  trial.scheduler = "catan";
  trial.speed = setting.medium_speed;
  trial.seed = setting.seed;
  trial.seconds = setting.slowdown * (setting.quick ? kQuickSeconds : kSeconds);
  Trial by_default = trial;
  by_default.scheduler = "default";
  return {trial, by_default};
}

std::filesystem::path record_of(const std::filesystem::path& folder, const Trial& trial) {
  return folder / (trial.scheduler + ".catan");
}

Result<std::optional<page::Glance>> write_look(const std::filesystem::path& folder, const Setting& setting) {
  std::vector<page::Story> stories;
  const std::array<Trial, 2> trials = looked_at(setting);
  for (const Trial& trial : trials) {
    const std::filesystem::path file = record_of(folder, trial);
    if (!std::filesystem::exists(file)) return std::optional<page::Glance>();
    const auto record = record::Reader::open(file.string());
    if (!record) return record.error();
    Result<page::Story> story = page::tell(*record);
    if (!story) return story.error();
    stories.push_back(std::move(*story));
  }
  const page::ShownRun ours{trials[0].scheduler, stories[0]};
  const page::ShownRun theirs{trials[1].scheduler, stories[1]};
  const Result<std::string> html = page::compare_html(ours, theirs);
  if (!html) return html.error();
  if (Status saved = page::save(*html, (folder / kLookPage).string()); !saved) return saved.error();
  return std::optional(page::glance(ours));
}

}  // namespace ctn::demo
